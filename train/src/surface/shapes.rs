//! Meshes of known shape, for tests.

use std::collections::HashMap;

use glam::Vec3;

use super::mesh::Mesh;

/// A grey mesh with these vertices and normals.
pub(super) fn mesh(places: &[Vec3], normals: &[Vec3], triangles: Vec<[u32; 3]>) -> Mesh {
    let arrays = |all: &[Vec3]| all.iter().map(|v| v.to_array()).collect::<Vec<_>>();
    let colors = vec![[128; 3]; places.len()];
    Mesh { positions: arrays(places), normals: arrays(normals), colors, triangles }
}

/// A ball of radius 1 around 0: an octahedron whose triangles are cut into four, so many times.
pub(super) fn ball(times: u32) -> Mesh {
    let mut places = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..times {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                places.push((places[a as usize] + places[b as usize]).normalize());
                places.len() as u32 - 1
            })
        };
        let four = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(four).collect();
    }
    mesh(&places, &places, triangles)
}

/// A strip of `long` by `wide` squares, two triangles each; `place` takes the number of a square's
/// corner along and across it.
pub(super) fn strip(long: u32, wide: u32, place: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let row = wide + 1;
    let places: Vec<Vec3> =
        (0..(long + 1) * row).map(|i| place((i / row) as f32, (i % row) as f32)).collect();
    let square = |i: u32| {
        let a = i / wide * row + i % wide;
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    };
    let normals = vec![Vec3::Z; places.len()];
    mesh(&places, &normals, (0..long * wide).flat_map(square).collect())
}

/// How often each edge is there, with its direction.
pub(super) fn edges(mesh: &Mesh) -> HashMap<[u32; 2], u32> {
    let mut edges = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for edge in [[*a, *b], [*b, *c], [*c, *a]] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges
}

/// Whether every edge is there once in each direction: no border, and triangles face one side.
pub(super) fn is_closed(mesh: &Mesh) -> bool {
    let edges = edges(mesh);
    edges.iter().all(|([a, b], n)| *n == 1 && edges.get(&[*b, *a]) == Some(&1))
}
