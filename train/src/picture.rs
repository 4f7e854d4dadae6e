//! Whole pictures of a model, tiles in parallel.

use pocketnerf_core::render::RenderStats;
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tile, Tuning, render_tile};
use rayon::prelude::*;

/// Width and height of a tile: as many pixels as rays travel together, and so
/// narrow that sixteen that march side by side are a square of the picture.
const TILE: [u32; 2] = [4, 64];

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
    let [w, h] = TILE;
    let corners = (0..height)
        .step_by(h as usize)
        .flat_map(|y| (0..width).step_by(w as usize).map(move |x| (x, y)));
    corners
        .map(|(x, y)| Tile { x, y, width: w.min(width - x), height: h.min(height - y) })
        .collect()
}

/// Renders the picture that `camera` takes, on all threads of the current pool.
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render(
    model: &Model<'_>,
    camera: &Camera,
    simd: SimdLevel,
    skip: bool,
) -> Result<Picture, Error> {
    let options = RenderOptions { skip, ..RenderOptions::new(model, simd, Tuning::FAST) };
    render_with(model, camera, &options)
}

/// The same with any options.
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render_with(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
) -> Result<Picture, Error> {
    let (width, height) = (camera.width, camera.height);
    let tiles = tiles(width, height);
    let parts: Result<Vec<_>, Error> = tiles
        .par_iter()
        .map_init(
            || vec![0.0; options.scratch_len()],
            |scratch, tile| {
                let mut rgba = vec![0.0; tile.pixels() * 4];
                let mut depth = vec![0.0; tile.pixels()];
                let to = (&mut rgba, &mut depth);
                let stats = render_tile(model, camera, *tile, options, scratch, to.0, Some(to.1))?;
                Ok((rgba, depth, stats))
            },
        )
        .collect();
    let pixels = width as usize * height as usize;
    let mut picture = Picture {
        width,
        height,
        rgba: vec![0.0; pixels * 4],
        depth: vec![0.0; pixels],
        stats: RenderStats::default(),
    };
    for (tile, (rgba, depth, stats)) in tiles.iter().zip(parts?) {
        picture.stats.rays += stats.rays;
        picture.stats.samples += stats.samples;
        let row = tile.width as usize;
        for y in 0..tile.height as usize {
            let to = (tile.y as usize + y) * width as usize + tile.x as usize;
            picture.rgba[to * 4..][..row * 4].copy_from_slice(&rgba[y * row * 4..][..row * 4]);
            picture.depth[to..][..row].copy_from_slice(&depth[y * row..][..row]);
        }
    }
    Ok(picture)
}
