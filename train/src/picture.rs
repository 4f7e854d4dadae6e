//! Whole pictures of a model, tiles in parallel.

use pocketnerf_core::render::Detail;
use pocketnerf_core::render::RenderStats;
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use rayon::prelude::*;

/// Pixels along a side of a tile: so many that its passes fill batches, so few
/// that threads end together.
const TILE: u32 = 64;

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
}

impl Default for Settings {
    /// As fast as this machine can, in the usual quality, without depth.
    fn default() -> Self {
        let (simd, detail) = (SimdLevel::detect(), Detail::default());
        Self { simd, skip: true, detail, depth: false }
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
}

/// The tiles of a picture, row after row.
pub(crate) fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let starts = |n: u32| (0..n).step_by(TILE as usize);
    let corners = starts(height).flat_map(|y| starts(width).map(move |x| (x, y)));
    corners
        .map(|(x, y)| Tile { x, y, width: TILE.min(width - x), height: TILE.min(height - y) })
        .collect()
}

/// Renders the picture that `camera` takes, on all threads of the current pool.
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render(model: &Model<'_>, camera: &Camera, settings: &Settings) -> Result<Picture, Error> {
    let Settings { simd, skip, detail, depth } = *settings;
    let options = RenderOptions { skip, detail, ..RenderOptions::new(model, simd, Tuning::FAST) };
    render_with(model, camera, &options, depth)
}

/// The same with any options, and with `depth` where wanted.
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render_with(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    depth: bool,
) -> Result<Picture, Error> {
    let (width, height) = (camera.width, camera.height);
    let tiles = tiles(width, height);
    let depth_len = |pixels: usize| if depth { pixels } else { 0 };
    let parts: Result<Vec<_>, Error> = tiles
        .par_iter()
        .map_init(
            || vec![0.0; options.scratch_len()],
            |scratch, tile| {
                let mut rgba = vec![0.0; tile.pixels() * 4];
                let mut depths = vec![0.0; depth_len(tile.pixels())];
                let to = (&mut rgba, depth.then_some(&mut depths[..]));
                let stats = render_tile(model, camera, *tile, options, scratch, to.0, to.1)?;
                Ok((rgba, depths, stats))
            },
        )
        .collect();
    let pixels = width as usize * height as usize;
    let mut picture = Picture {
        width,
        height,
        rgba: vec![0.0; pixels * 4],
        depth: vec![0.0; depth_len(pixels)],
        stats: RenderStats::default(),
    };
    for (tile, (rgba, depth, stats)) in tiles.iter().zip(parts?) {
        picture.stats.rays += stats.rays;
        picture.stats.samples += stats.samples;
        let row = tile.width as usize;
        for y in 0..tile.height as usize {
            let to = (tile.y as usize + y) * width as usize + tile.x as usize;
            picture.rgba[to * 4..][..row * 4].copy_from_slice(&rgba[y * row * 4..][..row * 4]);
            if !depth.is_empty() {
                picture.depth[to..][..row].copy_from_slice(&depth[y * row..][..row]);
            }
        }
    }
    Ok(picture)
}
