//! Surfaces of a model: triangles with colours and normals.
//!
//! A density has no surface of its own. What a camera sees has one: where the light of a pixel
//! begins to be held back. Depth maps of many cameras are put together as distances in a
//! grid of voxels, positive before what is seen and negative behind it, cut off a few voxels from
//! zero (Curless and Levoy, "A volumetric method for building complex models from range images",
//! 1996). Averaged over cameras, they are smooth where each depth map is noisy, and what lies
//! inside of bodies, where a radiance field may be anything, never counts. Zero becomes triangles
//! by surface nets (Gibson, "Constrained elastic surface nets", 1998): one vertex a voxel through
//! which it passes.
//!
//! ```
//! use pocketnerf_train::surface::{Mesh, file};
//!
//! let mesh = Mesh {
//!     positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     normals: vec![[0.0, 0.0, 1.0]; 3],
//!     colors: vec![[255, 0, 0]; 3],
//!     triangles: vec![[0, 1, 2]],
//! };
//! assert_eq!(mesh.area(), 0.5);
//! assert!(file::ply(&mesh).starts_with(b"ply\nformat binary_little_endian 1.0\n"));
//! ```

mod bounds;
mod colors;
mod compare;
pub mod file;
mod look;
mod mesh;
mod nearest;
mod nets;
mod parts;
#[cfg(test)]
mod shapes;
mod simplify;
mod smooth;
#[cfg(test)]
mod tests;
mod texture;
mod volume;

use pocketnerf_core::{Camera, Error, Model, SimdLevel};

pub use compare::{SurfaceError, compare};
pub use mesh::Mesh;
pub use texture::{Corner, SIZES, Texture, TooManyCharts, texture_bytes};

use glam::Vec3;
use look::Seen;
use volume::Volume;

/// How often the surface is smoothed.
const ROUNDS: u32 = 10;

/// How a surface is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// Voxels along the longest side of what is seen.
    pub resolution: u32,
    /// Smallest and largest corner of what is wanted, scene units; `None`: all that cameras see.
    pub crop: Option<[[f32; 3]; 2]>,
    /// Whether the surface is closed: what no camera sees counts as solid.
    pub watertight: bool,
}

impl Default for Settings {
    /// 256 voxels along the longest side, all that is seen and no more.
    fn default() -> Self {
        Self { simd: SimdLevel::detect(), resolution: 256, crop: None, watertight: false }
    }
}

/// Why there is no surface. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoSurface {
    /// No ray of any camera meets anything, or not within the box.
    #[error("no camera sees a surface{}; {}", if *.cropped { " in this box" } else { "" },
        if *.cropped { "give a larger one" } else { "give cameras that look at the scene" })]
    Nothing {
        /// Whether a box was asked for.
        cropped: bool,
    },
    /// The model is broken.
    #[error(transparent)]
    Model(#[from] Error),
}

/// How many pictures finding a surface takes: colours and depths of each camera, both at once
/// where space is bent.
#[must_use]
pub fn pictures(model: &Model<'_>, cameras: &[Camera]) -> usize {
    cameras.len() * if look::has_box(model) { 2 } else { 1 }
}

/// What finding a surface needs, bytes, about: pictures, and voxels at what is seen, or all of
/// them.
#[must_use]
pub fn memory_bytes(cameras: &[Camera], settings: &Settings) -> u64 {
    let side = u64::from(settings.resolution);
    let voxels = if settings.watertight { side * side * side } else { 64 * side * side };
    look::memory_bytes(cameras, settings) + 8 * voxels
}

/// A surface, and what cameras see of it: where it changes, they tell its colours.
#[derive(Debug)]
pub struct Surface {
    /// Its triangles, scene units.
    pub mesh: Mesh,
    seen: Vec<Seen>,
    /// How far from it what a camera sees may lie.
    near: f32,
}

impl Surface {
    /// Leaves at most so many triangles, as [`Mesh::simplify`] does, and finds normals and colours
    /// anew.
    pub fn simplify(&mut self, triangles: usize) {
        if self.mesh.triangles.len() > triangles {
            self.mesh.simplify(triangles);
            smooth::find_normals(&mut self.mesh);
            self.paint();
        }
    }

    /// What cameras see of each point, in an image of `size` texels a side, one of [`SIZES`]. `each`
    /// hears how many rows are done.
    ///
    /// # Errors
    /// [`TooManyCharts`].
    pub fn texture(&self, size: u32, each: impl FnMut(usize)) -> Result<Texture, TooManyCharts> {
        let color =
            |position: Vec3, normal: Vec3| colors::color(position, normal, &self.seen, self.near);
        texture::bake(&self.mesh, size, color, each)
    }

    fn paint(&mut self) {
        colors::paint(&mut self.mesh, &self.seen, self.near);
    }
}

/// The surface that `cameras` see, scene units. Triangles are counter-clockwise from outside,
/// normals point outside. Parts that are smaller than a thousandth of it are left out: most are
/// fog. `each` hears how many of [`pictures`] are done.
///
/// # Errors
/// [`NoSurface`].
pub fn surface(
    model: &Model<'_>,
    cameras: &[Camera],
    settings: &Settings,
    each: impl FnMut(usize),
) -> Result<Surface, NoSurface> {
    let seen = look::all(model, cameras, settings, each)?;
    let cropped = settings.crop.is_some();
    let nothing = NoSurface::Nothing { cropped };
    let Some(bounds) = bounds::of(&seen, model, settings.crop) else { return Err(nothing) };
    let mut volume = Volume::around(&seen, bounds, settings);
    volume.fill(&seen);
    let mut mesh = nets::mesh(&volume);
    parts::keep_large(&mut mesh);
    if mesh.triangles.is_empty() {
        return Err(nothing);
    }
    smooth::smooth(&mut mesh, ROUNDS);
    let mut surface = Surface { mesh, seen, near: volume.cut() };
    surface.paint();
    Ok(surface)
}
