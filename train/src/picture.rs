//! Whole pictures of a model, tiles in parallel.

use pocketnerf_core::render::{RenderStats, Tiles, render_rays};
use pocketnerf_core::{
    Camera, Error, Model, Ray, RenderOptions, SimdLevel, Tile, Tuning, pixel, render_tile,
};
use rayon::prelude::*;

use crate::lens::Lens;
use crate::pool::Pool;

/// Where along a ray the field is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Equal steps through occupied cells, until next to no light passes.
    #[default]
    Occupancy,
    /// As many samples for every ray as the paper takes, or as the model says: evenly
    /// spread, then where these have weight. `--quality` changes nothing.
    Paper,
}

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// Cross empty space in strides.
    pub skip: bool,
    /// From 0, the fastest, to 1, the finest: see [`Model::detail`].
    pub quality: f32,
    /// Whether depth is wanted.
    pub depth: bool,
    /// How much is worked on at a time.
    pub tuning: Tuning,
    /// Where along a ray the field is asked.
    pub sampling: Sampling,
}

impl Default for Settings {
    /// As fast as this machine can, in the usual quality, without depth.
    fn default() -> Self {
        Self {
            simd: SimdLevel::detect(),
            skip: true,
            quality: 0.5,
            depth: false,
            tuning: Tuning::FAST,
            sampling: Sampling::Occupancy,
        }
    }
}

impl Settings {
    /// The core's options.
    pub fn options(&self, model: &Model<'_>) -> RenderOptions {
        let Self { simd, skip, quality, tuning, .. } = *self;
        let options = RenderOptions {
            skip,
            detail: model.detail(quality),
            ..RenderOptions::new(model, simd, tuning)
        };
        match self.sampling {
            Sampling::Occupancy => options,
            Sampling::Paper => options.with_sampling(model.hierarchical_sampling()),
        }
    }
}

/// A rendered picture.
#[derive(Clone, Debug, Default)]
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
        pixels.flat_map(|rgba| pixel::over(*rgba, background)).collect()
    }
}

/// A tile of a picture, and the pieces of the picture's rows that it covers.
struct Part<'p> {
    tile: Tile,
    rgba: Vec<&'p mut [f32]>,
    /// Empty where it was not asked for.
    depth: Vec<&'p mut [f32]>,
}

/// Cuts a picture of so many columns into tiles.
fn parts<'p>(width: u32, height: u32, rgba: &'p mut [f32], depth: &'p mut [f32]) -> Vec<Part<'p>> {
    let part = |tile| Part { tile, rgba: Vec::new(), depth: Vec::new() };
    let tiles = Tiles::new(width, height);
    let [w, h] = tiles.size().map(|side| side as usize);
    let mut parts: Vec<Part<'p>> = tiles.map(part).collect();
    let row = width.max(1) as usize;
    let first = |y: usize| y / h * row.div_ceil(w);
    for (y, row) in rgba.chunks_mut(4 * row).enumerate() {
        let pieces = row.chunks_mut(4 * w).zip(&mut parts[first(y)..]);
        pieces.for_each(|(piece, part)| part.rgba.push(piece));
    }
    for (y, row) in depth.chunks_mut(row).enumerate() {
        let pieces = row.chunks_mut(w).zip(&mut parts[first(y)..]);
        pieces.for_each(|(piece, part)| part.depth.push(piece));
    }
    parts
}

/// What a thread needs: the renderer's scratch and a tile.
#[derive(Debug)]
struct Worker {
    scratch: Vec<f32>,
    rgba: Vec<f32>,
    depth: Vec<f32>,
}

impl Worker {
    fn new(options: &RenderOptions, depth: bool) -> Self {
        let n = Tiles::MOST_PIXELS;
        let scratch = vec![0.0; options.scratch_len()];
        Self { scratch, rgba: vec![0.0; 4 * n], depth: vec![0.0; if depth { n } else { 0 }] }
    }

    /// Renders a tile.
    fn render(
        &mut self,
        model: &Model<'_>,
        through: (&Camera, &Lens),
        options: &RenderOptions,
        part: Part<'_>,
    ) -> Result<RenderStats, Error> {
        let (tile, width) = (part.tile, part.tile.width as usize);
        let rgba = &mut self.rgba[..4 * tile.pixels()];
        let depth = (!part.depth.is_empty()).then(|| &mut self.depth[..tile.pixels()]);
        let scratch = &mut self.scratch;
        let stats = render_through(model, through, tile, options, scratch, rgba, depth)?;
        let rows = self.rgba.chunks_exact(4 * width).zip(part.rgba);
        rows.for_each(|(from, to)| to.copy_from_slice(from));
        let rows = self.depth.chunks_exact(width).zip(part.depth);
        rows.for_each(|(from, to)| to.copy_from_slice(from));
        Ok(stats)
    }
}

/// [`render_tile`] through a lens: where it bends rays, pixels are rendered one by one,
/// and none is interpolated.
pub(crate) fn render_through(
    model: &Model<'_>,
    (camera, lens): (&Camera, &Lens),
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    if *lens == Lens::Pinhole {
        return render_tile(model, camera, tile, options, scratch, rgba, depth);
    }
    let Tile { x, y, width, height } = tile;
    let pixels = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    let ray = |(x, y)| lens.ray(camera, x as f32 + 0.5, y as f32 + 0.5);
    let rays: Vec<Ray> = pixels.map(ray).collect();
    render_rays(model, &rays, options, scratch, rgba, depth)
}

/// Copies a tile, `channels` values a pixel, to its columns of rows of `row` pixels.
pub(crate) fn copy_rows(from: &[f32], to: &mut [f32], channels: usize, tile: Tile, row: usize) {
    let n = tile.width as usize * channels;
    for (from, to) in from.chunks_exact(n).zip(to.chunks_exact_mut(row * channels)) {
        to[tile.x as usize * channels..][..n].copy_from_slice(from);
    }
}

/// Renders pictures one after another, in memory that it keeps.
#[derive(Debug)]
pub struct Renderer<'m> {
    model: &'m Model<'m>,
    options: RenderOptions,
    depth: bool,
    workers: Pool<Worker>,
    picture: Picture,
}

impl<'m> Renderer<'m> {
    /// To render `model`.
    #[must_use]
    pub fn new(model: &'m Model<'m>, settings: &Settings) -> Self {
        Self::with_options(model, settings.options(model), settings.depth)
    }

    /// The same with any options, and with `depth` where wanted.
    #[must_use]
    pub fn with_options(model: &'m Model<'m>, options: RenderOptions, depth: bool) -> Self {
        Self { model, options, depth, workers: Pool::default(), picture: Picture::default() }
    }

    /// Renders the picture that `camera` takes, on all threads of the current pool.
    ///
    /// # Errors
    /// Whatever [`render_tile`] reports.
    pub fn render(&mut self, camera: &Camera) -> Result<&Picture, Error> {
        self.render_through(camera, &Lens::Pinhole)
    }

    /// Renders the picture that `camera` takes through `lens`. Where the lens shows
    /// nothing, see [`Lens::undistort`].
    ///
    /// # Errors
    /// Whatever [`render_tile`] reports.
    pub fn render_through(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error> {
        let Self { model, options, depth, workers, picture } = self;
        let (width, height) = (camera.width, camera.height);
        let pixels = width as usize * height as usize;
        picture.rgba.resize(pixels * 4, 0.0);
        picture.depth.resize(if *depth { pixels } else { 0 }, 0.0);
        let stats = parts(width, height, &mut picture.rgba, &mut picture.depth)
            .into_iter()
            // A bridge hands tiles out in their order: neighbours at the same time.
            .par_bridge()
            .map(|part| {
                let mut worker = workers.take(|| Worker::new(options, *depth));
                let stats = worker.render(model, (camera, lens), options, part);
                workers.put(worker);
                stats
            })
            .try_reduce(RenderStats::default, |mut a, b| {
                a += b;
                Ok(a)
            })?;
        (picture.width, picture.height, picture.stats) = (width, height, stats);
        Ok(picture)
    }
}

/// What rendering needs beside the model's file and the picture, bytes: the table of
/// what lies around its cells, and scratch and a tile for each thread of the current pool.
#[must_use]
pub fn memory_bytes(model: &Model<'_>, settings: &Settings) -> u64 {
    let tile = Tiles::MOST_PIXELS * if settings.depth { 5 } else { 4 };
    let floats = settings.options(model).scratch_len() + tile;
    (model.table_len() + rayon::current_num_threads() * floats * size_of::<f32>()) as u64
}

/// Renders one picture: see [`Renderer::render`].
///
/// # Errors
/// Whatever [`render_tile`] reports.
pub fn render(model: &Model<'_>, camera: &Camera, settings: &Settings) -> Result<Picture, Error> {
    let mut renderer = Renderer::new(model, settings);
    renderer.render(camera)?;
    Ok(renderer.picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Layout;
    use crate::trainer::{Length, TrainConfig};

    #[test]
    fn a_thread_renders_in_less_than_a_mebibyte() {
        // Of a table of half a mebibyte, each of two threads has half.
        const TABLE: usize = (1 << 19) / 2;
        let long = TrainConfig::hash_grid().for_length(Length::Seconds(1200.0));
        for config in [TrainConfig::hash_grid(), long.clone(), long.for_speed()] {
            let layout = Layout::new(&config.field);
            let parameters = vec![0.0; layout.len()];
            let field = layout.view(&config.field, &parameters).unwrap();
            let tuning = Tuning::FAST;
            let scratch = pocketnerf_core::scratch::scratch_len(field.limits(), tuning);
            let tile = 4 * Tiles::MOST_PIXELS;
            let bytes = size_of::<f32>() * (scratch + tile) + TABLE;
            assert!(bytes <= 1 << 20, "{bytes}");
        }
    }
}
