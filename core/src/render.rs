//! Rays through a model to pixels: the only loop over pixels.
//!
//! A tile's rays travel together. In every round each active ray adds its next
//! few occupied samples to a batch, the field evaluates the whole batch, and
//! each ray composites its own part, so that a ray which has become opaque
//! needs nothing more. Where a picture need not be the finest, a pixel whose
//! neighbours agree is their mean.

mod average;
mod composite;
mod detail;
mod driver;
mod finish;
mod foreground;
mod hierarchical;
mod observe;
mod passes;
mod progressive;
mod ray_group;
mod rehearse;
mod source;
mod target;
mod tiles;

pub use crate::march::Stage;
pub use average::average_tile;
pub use detail::Detail;
pub use observe::{Observer, observe_tile};
pub use progressive::{Refinement, Refinements, refine_tile};
pub use rehearse::rehearse_tile;
pub use tiles::Tiles;

use crate::march::Hierarchical;
use crate::scratch::{Limits, Tuning, scratch_len};
use crate::{Camera, Error, Model, Ray, SimdLevel};
use driver::Job;
use passes::Span;
use source::Pixels;

/// Where along a ray the field is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplingMode {
    /// In occupied cells, in equal steps, until next to no light passes.
    #[default]
    Occupancy,
    /// As in the NeRF paper: at evenly spaced distances, then where these have weight.
    /// Every pixel is rendered and no ray ends early, whatever `detail` says. Needs the
    /// cargo feature `nerf`.
    Hierarchical(Hierarchical),
}

/// Whether this build samples hierarchically: builds that link no vanilla NeRF omit it.
const HIERARCHICAL: bool = cfg!(feature = "nerf");

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
    /// Where along a ray the field is evaluated; see [`with_sampling`](Self::with_sampling).
    pub sampling: SamplingMode,
    /// A call ends with [`Error::TooManySamples`] once the field has been evaluated at more
    /// samples than this, times the pixels: a small file may ask for hours of work.
    pub max_samples_per_pixel: u32,
}

impl RenderOptions {
    /// Samples a pixel that are allowed by default. Sound models take fewer than a hundred;
    /// converted ones with large scenes around them, and fog, a few thousand.
    pub const MAX_SAMPLES_PER_PIXEL: u32 = 1 << 15;

    /// The usual way to render `model`: all it needs and no more.
    #[must_use]
    pub fn new(model: &Model<'_>, simd: SimdLevel, tuning: Tuning) -> Self {
        let (limits, detail) = (model.field.limits(), model.detail(0.5));
        Self {
            simd,
            limits,
            tuning,
            skip: true,
            detail,
            sampling: SamplingMode::Occupancy,
            max_samples_per_pixel: Self::MAX_SAMPLES_PER_PIXEL,
        }
    }

    /// The same with another sampling, and the scratch that it needs.
    #[must_use]
    pub const fn with_sampling(mut self, sampling: SamplingMode) -> Self {
        self.sampling = sampling;
        self.limits.ray_samples = match &sampling {
            SamplingMode::Occupancy => 0,
            SamplingMode::Hierarchical(hierarchical) => hierarchical.n_all(),
        };
        self
    }

    fn check(&self, model: &Model<'_>) -> Result<(), Error> {
        // Cheap beside a tile's work, and kernels rely on it.
        model.validate()?;
        model.fits(&self.limits)?;
        if let SamplingMode::Hierarchical(hierarchical) = &self.sampling {
            if !HIERARCHICAL {
                return Err(Error::Feature("nerf"));
            }
            hierarchical.validate()?;
            if hierarchical.n_all() > self.limits.ray_samples {
                return Err(Error::Limits("samples of a ray"));
            }
        }
        self.detail.validate()?;
        self.tuning.validate()
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

    /// The same part of a picture that has `n` times as many pixels along each side:
    /// [`Camera::finer`].
    #[must_use]
    pub const fn finer(&self, n: u32) -> Self {
        Self {
            x: self.x.saturating_mul(n),
            y: self.y.saturating_mul(n),
            width: self.width.saturating_mul(n),
            height: self.height.saturating_mul(n),
        }
    }
}

/// What rendering a tile took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStats {
    /// Rays cast; the other pixels are interpolated, or empty before one is cast.
    pub rays: u64,
    /// Samples at which the field was evaluated; in hierarchical sampling, both networks
    /// together.
    pub samples: u64,
    /// Rays with any such sample.
    pub hits: u64,
}

impl core::ops::AddAssign for RenderStats {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.samples += other.samples;
        self.hits += other.hits;
    }
}

/// Renders a tile of the picture that `camera` takes of `model`.
///
/// `rgba` receives four values a pixel, row after row of the tile: red, green
/// and blue premultiplied by alpha, without background, and alpha (opacity).
/// `depth`, where wanted, receives one value a pixel: the expected Euclidean
/// distance in scene units, infinite where the ray meets nothing. (In a space that is no
/// box it is the distance of the mean in the space's own coordinates.)
/// `scratch` may hold anything; its length is [`RenderOptions::scratch_len`].
///
/// # Errors
/// When the parts of the model do not fit together, it exceeds
/// `options.limits`, a slice is too short, or the SIMD level is not there: nothing is
/// written then. [`Error::TooManySamples`] where the model asks for more work than
/// `options.max_samples_per_pixel` allows: the outputs then hold anything.
pub fn render_tile(
    model: &Model<'_>,
    camera: &Camera,
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    let (source, span) = (&Pixels { camera, tile }, Span::all(options.detail.spacing()));
    driver::render(&Job { model, source, options, span }, scratch, rgba, depth, None)
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
    let job = Job { model, source: rays, options, span: Span::all(1) };
    driver::render(&job, scratch, rgba, depth, None)
}
