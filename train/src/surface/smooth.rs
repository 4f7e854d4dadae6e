//! Smoothing that does not shrink (Taubin, "A signal processing approach to fair surface design",
//! 1995).

use glam::Vec3;

use super::mesh::Mesh;

/// How far a vertex moves towards the mean of its neighbours, and then away from it.
const STEPS: [f32; 2] = [0.5, -0.53];

/// Takes out what changes from vertex to vertex, `rounds` times, and finds normals anew. The mesh
/// keeps its volume; where it is open, its border stays.
pub(super) fn smooth(mesh: &mut Mesh, rounds: u32) {
    let pinned = border(mesh);
    for step in (0..rounds).flat_map(|_| STEPS) {
        let mut around = vec![(Vec3::ZERO, 0.0_f32); mesh.positions.len()];
        for triangle in &mesh.triangles {
            let corners = mesh.corners(*triangle);
            for (i, vertex) in triangle.iter().enumerate() {
                // Inside of a closed surface, each neighbour is met twice.
                let (sum, n) = &mut around[*vertex as usize];
                *sum += corners[(i + 1) % 3] + corners[(i + 2) % 3];
                *n += 2.0;
            }
        }
        let vertices = mesh.positions.iter_mut().zip(around).zip(&pinned);
        for ((position, (sum, n)), _) in vertices.filter(|(_, pinned)| !**pinned) {
            let p = Vec3::from(*position);
            *position = (p + step * (sum / n - p)).to_array();
        }
    }
    find_normals(mesh);
}

/// Vertices at the end of an open surface.
fn border(mesh: &Mesh) -> Vec<bool> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * mesh.triangles.len());
    for [a, b, c] in &mesh.triangles {
        edges.extend([[*a, *b], [*b, *c], [*c, *a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    let mut is_border = vec![false; mesh.positions.len()];
    for same in edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
        same[0].iter().for_each(|vertex| is_border[*vertex as usize] = true);
    }
    is_border
}

/// The mean of the normals of the triangles at each vertex, larger ones counting more.
pub(super) fn find_normals(mesh: &mut Mesh) {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(*triangle);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|vertex| normals[*vertex as usize] += normal);
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(normals) {
        *normal = sum.normalize_or(Vec3::from(*normal)).to_array();
    }
}
