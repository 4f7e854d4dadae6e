//! Rays through a model to pixels: the only loop over pixels.
//!
//! A tile's rays travel together. In every round each living ray adds its next
//! few occupied samples to a batch, the field answers for the whole batch, and
//! each ray composites its own part, so that a ray which has become opaque
//! asks for nothing more.

mod group;

use fearless_simd::dispatch;

use crate::sampler::{LANES, Marcher};
use crate::scratch::{Limits, Scratch, Tuning, scratch_len};
use crate::{Camera, Error, Model, Ray, SimdLevel};
use group::Group;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// What the scratch was sized for.
    pub limits: Limits,
    /// How much is worked on at a time.
    pub tuning: Tuning,
    /// Cross empty space in strides. Without it every step is tested on its
    /// own: the same picture, slower.
    pub skip: bool,
}

impl RenderOptions {
    /// The usual way to render `model`: all it needs and no more.
    #[must_use]
    pub fn new(model: &Model<'_>, simd: SimdLevel, tuning: Tuning) -> Self {
        Self { simd, limits: model.field.limits(), tuning, skip: true }
    }

    fn check(&self, model: &Model<'_>) -> Result<(), Error> {
        // Cheap beside a tile's work, and kernels rely on it.
        model.validate()?;
        model.fits(&self.limits)?;
        let Tuning { samples, rays } = self.tuning;
        let multiples = samples.is_multiple_of(32) && rays.is_multiple_of(LANES);
        if !multiples || rays == 0 || rays > samples {
            return Err(Error::Range(
                "tuning: samples a multiple of 32, rays of 16 and no more than samples",
            ));
        }
        Ok(())
    }

    /// `f32` values of scratch to hand to [`render_tile`].
    #[must_use]
    pub const fn scratch_len(&self) -> usize {
        scratch_len(self.limits, self.tuning)
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Tile {
    /// Pixels in the tile.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        (self.width as usize).saturating_mul(self.height as usize)
    }
}

/// What rendering a tile took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStats {
    /// Rays cast.
    pub rays: u64,
    /// Samples at which the field was asked.
    pub samples: u64,
}

/// Renders a tile of the picture that `camera` takes of `model`.
///
/// `rgba` receives four values a pixel, row after row of the tile: red, green
/// and blue premultiplied by alpha, without background, and alpha (opacity).
/// `depth`, where wanted, receives one value a pixel: the expected Euclidean
/// distance in scene units, infinite where the ray meets nothing.
/// `scratch` may hold anything; its length is [`RenderOptions::scratch_len`].
///
/// # Errors
/// When the parts of the model do not fit together, it exceeds
/// `options.limits`, a slice is too short, or the SIMD level is not there.
/// Nothing is written then.
pub fn render_tile(
    model: &Model<'_>,
    camera: &Camera,
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    let pixel = |i: usize| {
        let width = tile.width as usize;
        let (x, y) = ((i % width) as u32, (i / width) as u32);
        let (x, y) = (tile.x.saturating_add(x), tile.y.saturating_add(y));
        camera.ray(x as f32 + 0.5, y as f32 + 0.5)
    };
    render(model, tile.pixels(), pixel, options, scratch, rgba, depth)
}

/// Renders any rays: the same as [`render_tile`], one pixel a ray.
///
/// # Errors
/// As [`render_tile`].
pub fn render_rays(
    model: &Model<'_>,
    rays: &[Ray],
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    render(model, rays.len(), |i| rays[i], options, scratch, rgba, depth)
}

fn render(
    model: &Model<'_>,
    n: usize,
    ray: impl Fn(usize) -> Ray,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    mut depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    options.check(model)?;
    if scratch.len() < options.scratch_len() {
        let (needed, given) = (options.scratch_len(), scratch.len());
        return Err(Error::ScratchTooSmall { needed, given });
    }
    let depth_len = depth.as_ref().map_or(usize::MAX, |d| d.len());
    for (needed, given) in [(n.saturating_mul(4), rgba.len()), (n, depth_len)] {
        if given < needed {
            return Err(Error::OutputLength { needed, given });
        }
    }
    let level = options.simd.token()?;
    let RenderOptions { limits, tuning, skip, .. } = *options;
    let mut scratch = Scratch::cut(scratch, limits, tuning);
    let marcher = Marcher::new(model, skip);
    let mut stats = RenderStats { rays: n as u64, samples: 0 };
    for first in (0..n).step_by(tuning.rays) {
        let count = tuning.rays.min(n - first);
        let group = Group { model, marcher, most_samples: tuning.samples, count };
        let rgba = rgba[first * 4..].as_chunks_mut::<4>().0;
        let depth = depth.as_mut().map(|d| &mut d[first..]);
        let rays = |i: usize| ray(first + i);
        stats.samples +=
            dispatch!(level, simd => group.render(simd, rays, &mut scratch, rgba, depth));
    }
    Ok(stats)
}
