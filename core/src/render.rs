//! Rays through a model to pixels: the only loop over pixels.
//!
//! A tile's rays travel together. In every round each living ray adds its next
//! few occupied samples to a batch, the field answers for the whole batch, and
//! each ray composites its own part, so that a ray which has become opaque
//! asks for nothing more. Where a picture need not be the finest, a pixel whose
//! neighbours agree is their mean.

mod detail;
mod finish;
mod flight;
mod group;
mod passes;
mod source;
mod target;

pub use detail::Detail;

use fearless_simd::{Simd, dispatch};

use crate::field::{AnyField, Field};
use crate::sampler::{LANES, Marcher};
use crate::scratch::{Limits, Scratch, Tuning, scratch_len};
use crate::store::{F16, F32, Store};
use crate::tensor::DType;
use crate::{Camera, Error, Model, Ray, SimdLevel};
use group::Group;
use passes::Pass;
use source::{Pixels, Source};
use target::Target;

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
    /// What may be left out.
    pub detail: Detail,
}

impl RenderOptions {
    /// The usual way to render `model`: all it needs and no more.
    #[must_use]
    pub fn new(model: &Model<'_>, simd: SimdLevel, tuning: Tuning) -> Self {
        Self { simd, limits: model.field.limits(), tuning, skip: true, detail: Detail::default() }
    }

    fn check(&self, model: &Model<'_>) -> Result<(), Error> {
        // Cheap beside a tile's work, and kernels rely on it.
        model.validate()?;
        model.fits(&self.limits)?;
        self.detail.validate()?;
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
    render(
        model,
        [tile.width, tile.height],
        &Pixels { camera, tile },
        options,
        scratch,
        rgba,
        depth,
    )
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
    let n = u32::try_from(rays.len()).map_err(|_| Error::Range("number of rays"))?;
    let options =
        &RenderOptions { detail: Detail { tolerances: [0.0; 4], ..options.detail }, ..*options };
    render(model, [n, 1], rays, options, scratch, rgba, depth)
}

fn render(
    model: &Model<'_>,
    [width, height]: [u32; 2],
    source: &(impl Source + ?Sized),
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    options.check(model)?;
    if scratch.len() < options.scratch_len() {
        let (needed, given) = (options.scratch_len(), scratch.len());
        return Err(Error::ScratchTooSmall { needed, given });
    }
    let n = (width as usize).saturating_mul(height as usize);
    let depth_len = depth.as_ref().map_or(usize::MAX, |d| d.len());
    for (needed, given) in [(n.saturating_mul(4), rgba.len()), (n, depth_len)] {
        if given < needed {
            return Err(Error::OutputLength { needed, given });
        }
    }
    let level = options.simd.token()?;
    let RenderOptions { limits, tuning, skip, detail, .. } = *options;
    let mut group = Group {
        model,
        marcher: Marcher::new(model, skip),
        tuning,
        min_transmittance: detail.min_transmittance.max(model.sampling.min_transmittance),
        scratch: Scratch::cut(scratch, limits, tuning),
        count: 0,
        samples: 0,
    };
    let mut target =
        Target { rgba: rgba.as_chunks_mut().0, depth, width, cell: source.cell(model) };
    let passes = passes::passes(width, height, detail.spacing());
    dispatch!(level, simd => match &model.field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => {
            each_pass(simd, field, &mut group, source, passes, detail, &mut target);
        }
        #[cfg(feature = "frequency")]
        AnyField::Frequency(field) => {
            each_pass(simd, field, &mut group, source, passes, detail, &mut target);
        }
    });
    Ok(RenderStats { rays: n as u64, samples: group.samples })
}

/// Opens the stored type: from here on it and the kind of field are types.
#[inline(always)]
fn each_pass<S: Simd, F: Field>(
    simd: S,
    field: &F,
    group: &mut Group<'_, '_>,
    source: &(impl Source + ?Sized),
    passes: impl Iterator<Item = Pass>,
    detail: Detail,
    target: &mut Target<'_>,
) {
    for pass in passes {
        match field.decoder().density.layers()[0].weight.dtype() {
            DType::F32 => one_pass::<S, F32, F>(simd, field, group, source, pass, detail, target),
            DType::F16 => one_pass::<S, F16, F>(simd, field, group, source, pass, detail, target),
        }
    }
}

#[inline(always)]
fn one_pass<S: Simd, T: Store, F: Field>(
    simd: S,
    field: &F,
    group: &mut Group<'_, '_>,
    source: &(impl Source + ?Sized),
    pass: Pass,
    detail: Detail,
    target: &mut Target<'_>,
) {
    let tolerance = detail.tolerance(pass.half());
    let mut pixels = pass.pixels();
    loop {
        let (mut numbers, mut n) = ([0; LANES], 0);
        for [x, y] in pixels.by_ref() {
            if pass.half() > 0 && target.interpolate(pass, [x, y], tolerance) {
                continue;
            }
            numbers[n] = y * target.width + x;
            n += 1;
            if n == LANES {
                break;
            }
        }
        group.add(simd, source, &numbers[..n], |pixel| target.clear(pixel));
        // What is left of a pass goes before the next begins, which reads it.
        if group.is_full() || (n < LANES && group.count > 0) {
            group.march::<S, T, F>(simd, field);
            group.finish::<S, T>(simd, field.decoder(), target);
        }
        if n < LANES {
            return;
        }
    }
}
