//! Colours of a mesh in an image.
//!
//! Triangles that hang together and face the same of the six axes make a chart: projected along
//! that axis, they lie side by side. Charts are packed into a square with gutters between them.

mod bake;
mod charts;
mod flat;
mod pack;
mod spread;
#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};
use image::ImageError;

use super::mesh::Mesh;
use crate::picture::image_file::encode_rgb;

/// Widths of textures, texels.
pub const SIZES: [u32; 6] = [256, 512, 1024, 2048, 4096, 8192];

/// A mesh's colours in a square image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width and height, texels; one of [`SIZES`].
    pub size: u32,
    /// sRGB, rows from the top.
    pub rgb: Vec<u8>,
    /// The mesh's vertices, each once for every chart that it is in.
    pub corners: Vec<Corner>,
    /// Numbers of corners, for each triangle of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// How many charts there are.
    pub charts: usize,
    /// The share of texels that show the surface.
    pub used: f64,
}

/// A vertex in a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Its number in the mesh.
    pub vertex: u32,
    /// Its place in the image: 0, 0 is the upper left corner, 1, 1 the lower right one.
    pub uv: [f32; 2],
}

/// Why there is no texture. The message is one line.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{charts} charts do not fit into a texture of {size}x{size} texels; give a larger one, or \
     fewer triangles"
)]
pub struct TooManyCharts {
    /// How many there are.
    pub charts: usize,
    /// Width and height, texels.
    pub size: u32,
}

impl Texture {
    /// The image as a PNG file.
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        encode_rgb(self.size, self.size, &self.rgb)
    }
}

/// What baking a texture needs, bytes, about: owners and colours of texels, and the files made of
/// them.
#[must_use]
pub fn texture_bytes(size: u32) -> u64 {
    24 * u64::from(size) * u64::from(size)
}

/// Bakes `color`, sRGB from 0 to 255 at a point of the surface and the normal there. Where it
/// knows none, neighbours tell, and then the mesh's vertices. `each` hears how many rows are done.
pub(super) fn bake(
    mesh: &Mesh,
    size: u32,
    color: impl Fn(Vec3, Vec3) -> Option<Vec3> + Sync,
    each: impl FnMut(usize),
) -> Result<Texture, TooManyCharts> {
    let charts = charts::of(mesh);
    let outlines: Vec<_> = charts.iter().map(|chart| chart.outline(mesh)).collect();
    let packed = pack::pack(&outlines, size).ok_or(TooManyCharts { charts: charts.len(), size })?;
    let mut corners = Vec::new();
    let mut triangles = vec![[0; 3]; mesh.triangles.len()];
    // The last corner of each vertex, and its chart.
    let mut last = vec![[u32::MAX; 2]; mesh.positions.len()];
    for (number, (chart, origin)) in charts.iter().zip(&packed.origins).enumerate() {
        for triangle in &chart.triangles {
            let triangle = *triangle as usize;
            triangles[triangle] = mesh.triangles[triangle].map(|vertex| {
                let last = &mut last[vertex as usize];
                if last[0] != number as u32 {
                    *last = [number as u32, corners.len() as u32];
                    let place = chart.flat(Vec3::from(mesh.positions[vertex as usize]));
                    let texels: Vec2 = *origin + (place - chart.min) / packed.texel;
                    corners.push(Corner { vertex, uv: (texels / size as f32).to_array() });
                }
                last[1]
            });
        }
    }
    let charts = charts.len();
    let mut texture = Texture { size, rgb: Vec::new(), corners, triangles, charts, used: 0.0 };
    bake::colors(&mut texture, mesh, color, each);
    Ok(texture)
}
