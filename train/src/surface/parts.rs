//! Parts of a mesh that hang together.

use super::mesh::Mesh;

/// Parts of less than this share of the whole area are left out.
const SMALL: f64 = 1e-3;

/// Leaves out small parts.
pub(super) fn keep_large(mesh: &mut Mesh) {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for [a, b, c] in &mesh.triangles {
        join(&mut parent, *a, *b);
        join(&mut parent, *b, *c);
    }
    let mut areas = vec![0.0; mesh.positions.len()];
    for triangle in &mesh.triangles {
        areas[root(&mut parent, triangle[0]) as usize] += f64::from(mesh.area_of(*triangle));
    }
    let least = SMALL * areas.iter().sum::<f64>();
    mesh.triangles.retain(|triangle| areas[root(&mut parent, triangle[0]) as usize] >= least);
    mesh.drop_unused();
}

/// The vertex that stands for the part in which this one is.
fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        let above = parent[parent[vertex as usize] as usize];
        parent[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}
