//! Triangles.

use glam::Vec3;
use pocketnerf_core::query::Similarity;

/// Triangles with a normal and a colour at each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors that point outside, one a vertex.
    pub normals: Vec<[f32; 3]>,
    /// sRGB, one a vertex.
    pub colors: Vec<[u8; 3]>,
    /// Numbers of vertices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|vertex| Vec3::from(self.positions[vertex as usize]))
    }

    /// The area of all triangles.
    #[must_use]
    pub fn area(&self) -> f64 {
        let areas = self.triangles.iter().map(|triangle| f64::from(self.area_of(*triangle)));
        areas.sum()
    }

    pub(super) fn area_of(&self, triangle: [u32; 3]) -> f32 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Smallest and largest corner of the box around all vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let first = Vec3::from(*self.positions.first()?);
        let (low, high) = self.positions.iter().fold((first, first), |(low, high), p| {
            (low.min(Vec3::from(*p)), high.max(Vec3::from(*p)))
        });
        Some([low.to_array(), high.to_array()])
    }

    /// The same mesh in a dataset's coordinates, to which `similarity` takes the model's.
    pub fn move_to_dataset(&mut self, similarity: &Similarity) {
        for position in &mut self.positions {
            *position = similarity.to_dataset(*position);
        }
        let turn =
            |n: [f32; 3]| similarity.rotation.map(|row| (0..3).map(|i| row[i] * n[i]).sum::<f32>());
        for normal in &mut self.normals {
            *normal = turn(*normal);
        }
    }

    /// Keeps the triangles that lie in a box of a dataset's coordinates, to which `similarity` takes
    /// the mesh's own.
    pub fn crop(&mut self, [low, high]: [[f32; 3]; 2], similarity: &Similarity) {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        let is_inside = |p: [f32; 3]| {
            let p = Vec3::from(similarity.to_dataset(p));
            p.cmpge(low).all() && p.cmple(high).all()
        };
        let inside: Vec<bool> = self.positions.iter().map(|p| is_inside(*p)).collect();
        self.triangles.retain(|triangle| triangle.iter().all(|vertex| inside[*vertex as usize]));
        self.drop_unused();
    }

    /// Leaves out vertices that no triangle has.
    pub(super) fn drop_unused(&mut self) {
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut kept = Self::default();
        for triangle in &self.triangles {
            kept.triangles.push(triangle.map(|vertex| {
                let old = vertex as usize;
                if number[old] == u32::MAX {
                    number[old] = kept.positions.len() as u32;
                    kept.positions.push(self.positions[old]);
                    kept.normals.push(self.normals[old]);
                    kept.colors.push(self.colors[old]);
                }
                number[old]
            }));
        }
        *self = kept;
    }
}
