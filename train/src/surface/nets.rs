//! Triangles where distances are zero: surface nets.

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::mesh::Mesh;
use super::volume::{POINTS, Volume, offset};

/// A voxel without a vertex.
const NONE: u32 = u32::MAX;
/// The corners of a voxel, x fastest.
const CORNERS: [UVec3; 8] = [
    UVec3::new(0, 0, 0),
    UVec3::new(1, 0, 0),
    UVec3::new(0, 1, 0),
    UVec3::new(1, 1, 0),
    UVec3::new(0, 0, 1),
    UVec3::new(1, 0, 1),
    UVec3::new(0, 1, 1),
    UVec3::new(1, 1, 1),
];
/// Its edges, by their corners.
const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// The surface, without colours. It ends where distances are not known.
pub(super) fn mesh(volume: &Volume) -> Mesh {
    let vertices: Vec<Vec<(usize, Vec3, Vec3)>> =
        volume.filled.par_iter().map(|block| vertices(volume, block.first)).collect();
    let mut mesh = Mesh::default();
    let mut numbers = vec![[NONE; POINTS]; volume.filled.len()];
    for (numbers, vertices) in numbers.iter_mut().zip(vertices) {
        for (place, position, normal) in vertices {
            numbers[place] = mesh.positions.len() as u32;
            mesh.positions.push(volume.scene(position).to_array());
            mesh.normals.push(normal.to_array());
        }
    }
    mesh.colors = vec![[0; 3]; mesh.positions.len()];
    for block in &volume.filled {
        for at in (0..POINTS).map(|place| block.first + offset(place)) {
            let here = volume.distance(at);
            for axis in 0..3 {
                let there = volume.distance(at + UVec3::AXES[axis]);
                if here.is_nan() || there.is_nan() || is_inside(here) == is_inside(there) {
                    continue;
                }
                let Some(quad) = around(volume, &numbers, at, axis) else { continue };
                mesh.add(quad, is_inside(there));
            }
        }
    }
    mesh.drop_unused();
    mesh
}

fn is_inside(distance: f32) -> bool {
    distance < 0.0
}

/// A vertex for each voxel of a block through which the surface passes: the mean of where it
/// crosses the voxel's edges. Gives the voxel's place in the block, the vertex on the lattice,
/// and the normal, along which distances grow.
fn vertices(volume: &Volume, first: UVec3) -> Vec<(usize, Vec3, Vec3)> {
    let vertex = |place: usize| {
        let voxel = first + offset(place);
        let distances = CORNERS.map(|corner| volume.distance(voxel + corner));
        let inside = distances.iter().filter(|d| is_inside(**d)).count();
        if inside == 0 || inside == CORNERS.len() || distances.iter().any(|d| d.is_nan()) {
            return None;
        }
        let mut sum = Vec3::ZERO;
        let mut n = 0.0;
        for [a, b] in EDGES {
            let [from, to] = [a, b].map(|corner| distances[corner]);
            if is_inside(from) != is_inside(to) {
                let [a, b] = [a, b].map(|corner| CORNERS[corner].as_vec3());
                sum += a.lerp(b, from / (from - to));
                n += 1.0;
            }
        }
        let slope: Vec3 =
            CORNERS.iter().zip(distances).map(|(c, d)| d * (2.0 * c.as_vec3() - 1.0)).sum();
        Some((place, voxel.as_vec3() + sum / n, slope.normalize_or(Vec3::Z)))
    };
    (0..POINTS).filter_map(vertex).collect()
}

/// The vertices of the four voxels around the edge from a lattice point along an axis, counter-
/// clockwise seen from where the axis points.
fn around(volume: &Volume, numbers: &[[u32; POINTS]], at: UVec3, axis: usize) -> Option<[u32; 4]> {
    let [u, v] = [UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]];
    if (at.cmpeq(UVec3::ZERO) & (u + v).cmpgt(UVec3::ZERO)).any() {
        return None;
    }
    let number = |voxel: UVec3| {
        let (block, place) = volume.place(voxel)?;
        Some(numbers[block][place]).filter(|number| *number != NONE)
    };
    Some([number(at - u - v)?, number(at - v)?, number(at)?, number(at - u)?])
}

impl Mesh {
    /// Two triangles, cut along the shorter diagonal; turned over where not `up`.
    fn add(&mut self, quad: [u32; 4], up: bool) {
        // Inside lies where the axis points, so that the outside sees it from the other end.
        let [a, b, c, d] = if up { [quad[3], quad[2], quad[1], quad[0]] } else { quad };
        let position = |vertex: u32| Vec3::from(self.positions[vertex as usize]);
        let short = |from, to| position(from).distance_squared(position(to));
        let pair = match short(a, c) <= short(b, d) {
            true => [[a, b, c], [a, c, d]],
            false => [[a, b, d], [b, c, d]],
        };
        self.triangles.extend(pair);
    }
}
