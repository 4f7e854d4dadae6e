//! Whole pictures of a model, tiles in parallel.

use pocketnerf_core::render::{Detail, RenderStats};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use rayon::prelude::*;

/// Pixels along a side of a tile: so many that its passes fill batches, so few
/// that its part of the tables stays in the cache and threads end together.
pub(crate) const TILE: u32 = 64;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// Cross empty space in strides.
    pub skip: bool,
    /// What may be left out.
    pub detail: Detail,
    /// Whether depth is wanted.
    pub depth: bool,
    /// How much is worked on at a time.
    pub tuning: Tuning,
}

impl Default for Settings {
    /// As fast as this machine can, in the usual quality, without depth.
    fn default() -> Self {
        Self {
            simd: SimdLevel::detect(),
            skip: true,
            detail: Detail::default(),
            depth: false,
            tuning: Tuning::FAST,
        }
    }
}

impl Settings {
    /// The core's options.
    pub(crate) fn options(&self, model: &Model<'_>) -> RenderOptions {
        let Self { simd, skip, detail, tuning, .. } = *self;
        RenderOptions { skip, detail, ..RenderOptions::new(model, simd, tuning) }
    }
}

/// A rendered picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Premultiplied RGBA, four values a pixel, without background.
    pub rgba: Vec<f32>,
    /// Expected Euclidean distance, scene units; infinite where nothing is.
    /// Empty where it was not asked for.
    pub depth: Vec<f32>,
    /// What it took.
    pub stats: RenderStats,
}

/// A tile of a picture.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) tile: Tile,
    rgba: Vec<f32>,
    depth: Vec<f32>,
    pub(crate) stats: RenderStats,
}

impl Part {
    pub(crate) fn new(tile: Tile, depth: bool) -> Self {
        let depth = vec![0.0; if depth { tile.pixels() } else { 0 }];
        Self { tile, rgba: vec![0.0; tile.pixels() * 4], depth, stats: RenderStats::default() }
    }

    /// Where its pixels go, and its depths if they are wanted.
    pub(crate) fn buffers(&mut self) -> (&mut [f32], Option<&mut [f32]>) {
        let depth = (!self.depth.is_empty()).then_some(&mut self.depth[..]);
        (&mut self.rgba, depth)
    }
}

impl Picture {
    /// RGB over a background, three values a pixel.
    #[must_use]
    pub fn over(&self, background: [f32; 3]) -> Vec<f32> {
        let pixels = self.rgba.as_chunks::<4>().0.iter();
        pixels
            .flat_map(|[r, g, b, a]| {
                let [br, bg, bb] = background.map(|c| c * (1.0 - a));
                [r + br, g + bg, b + bb]
            })
            .collect()
    }

    /// Puts tiles together; all have depths, or none has.
    pub(crate) fn assemble<'p>(
        camera: &Camera,
        parts: impl Iterator<Item = &'p Part> + Clone,
    ) -> Self {
        let (width, height) = (camera.width, camera.height);
        let pixels = width as usize * height as usize;
        let with_depth = parts.clone().any(|part| !part.depth.is_empty());
        let mut picture = Self {
            width,
            height,
            rgba: vec![0.0; pixels * 4],
            depth: vec![0.0; if with_depth { pixels } else { 0 }],
            stats: RenderStats::default(),
        };
        for part in parts {
            picture.stats += part.stats;
            let (tile, row) = (part.tile, part.tile.width as usize);
            for y in 0..tile.height as usize {
                let to = (tile.y as usize + y) * width as usize + tile.x as usize;
                let from = &part.rgba[y * row * 4..][..row * 4];
                picture.rgba[to * 4..][..row * 4].copy_from_slice(from);
                if with_depth {
                    picture.depth[to..][..row].copy_from_slice(&part.depth[y * row..][..row]);
                }
            }
        }
        picture
    }
}

/// Renders the picture that `camera` takes, on all threads of the current pool.
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render(model: &Model<'_>, camera: &Camera, settings: &Settings) -> Result<Picture, Error> {
    let options = settings.options(model);
    let (width, height) = (camera.width, camera.height);
    let starts = |n: u32| (0..n).step_by(TILE as usize);
    let corners = starts(height).flat_map(|y| starts(width).map(move |x| (x, y)));
    let mut parts: Vec<Part> = corners
        .map(|(x, y)| Tile { x, y, width: TILE.min(width - x), height: TILE.min(height - y) })
        .map(|tile| Part::new(tile, settings.depth))
        .collect();
    parts.par_iter_mut().try_for_each_init(
        || vec![0.0; options.scratch_len()],
        |scratch, part| {
            let tile = part.tile;
            let (rgba, depth) = part.buffers();
            part.stats = render_tile(model, camera, tile, &options, scratch, rgba, depth)?;
            Ok(())
        },
    )?;
    Ok(Picture::assemble(camera, parts.iter()))
}
