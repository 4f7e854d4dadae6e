//! Renders whole pictures, tiles in parallel.

use pocketnerf_core::render::{RenderStats, Tiles, average_tile};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, Tile};

#[cfg(feature = "gpu")]
use super::on_gpu::OnGpu;
use super::{Antialias, Device, Picture, Settings};
use crate::lens::{Lens, render_through};
use crate::pool::Pool;

/// Renders pictures one after another, in memory that it keeps.
#[derive(Debug)]
pub struct Renderer<'m> {
    model: &'m Model<'m>,
    options: RenderOptions,
    antialias: Antialias,
    depth: bool,
    workers: Pool<Worker>,
    picture: Picture,
    #[cfg(feature = "gpu")]
    gpu: Option<OnGpu>,
    fallback: Option<String>,
}

impl<'m> Renderer<'m> {
    /// To render `model`.
    #[must_use]
    pub fn new(model: &'m Model<'m>, settings: &Settings) -> Self {
        let Settings { antialias, depth, .. } = *settings;
        Self { antialias, ..Self::with_options(model, settings.options(model), depth) }
    }

    /// With any options, and with `depth` where wanted; one ray a pixel.
    #[must_use]
    pub fn with_options(model: &'m Model<'m>, options: RenderOptions, depth: bool) -> Self {
        Self {
            model,
            options,
            antialias: Antialias::Off,
            depth,
            workers: Pool::default(),
            picture: Picture::default(),
            #[cfg(feature = "gpu")]
            gpu: None,
            fallback: None,
        }
    }

    /// To render `model` on `device`, or on the CPU where that is impossible:
    /// [`fallback`](Self::fallback) says so.
    #[must_use]
    pub fn on(device: &Device, model: &'m Model<'m>, settings: &Settings) -> Self {
        #[cfg_attr(not(feature = "gpu"), allow(unused_mut, reason = "a GPU may be added"))]
        let mut renderer = Self::new(model, settings);
        match device {
            Device::Cpu => {}
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => match OnGpu::new(gpu, model, &renderer.options) {
                Ok(gpu) => renderer.gpu = Some(gpu),
                Err(why) => renderer.fallback = Some(why.to_string()),
            },
        }
        renderer
    }

    /// Why the CPU has rendered what another device was to; `None` where that did it.
    #[must_use]
    pub fn fallback(&self) -> Option<&str> {
        self.fallback.as_deref()
    }

    /// Renders the picture that `camera` takes, on all threads of the current pool.
    ///
    /// # Errors
    /// Whatever [`render_tile`](pocketnerf_core::render_tile) reports.
    pub fn render(&mut self, camera: &Camera) -> Result<&Picture, Error> {
        self.render_through(camera, &Lens::Pinhole)
    }

    /// Renders the picture that `camera` takes through `lens`. Where the lens shows
    /// nothing, see [`Lens::undistort`].
    ///
    /// # Errors
    /// Whatever [`render_tile`](pocketnerf_core::render_tile) reports.
    pub fn render_through(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error> {
        let (width, height) = (camera.width, camera.height);
        let pixels = width as usize * height as usize;
        let picture = &mut self.picture;
        picture.rgba.resize(pixels * 4, 0.0);
        picture.depth.resize(if self.depth { pixels } else { 0 }, 0.0);
        (picture.width, picture.height) = (width, height);
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &mut self.gpu {
            match gpu.render(camera, lens, self.antialias.rays(camera), picture) {
                Ok(()) => return Ok(&self.picture),
                Err(pocketnerf_gpu::Error::Model(error)) => return Err(error),
                Err(why) => (self.gpu, self.fallback) = (None, Some(why.to_string())),
            }
        }
        let Picture { mut rgba, mut depth, .. } = std::mem::take(&mut self.picture);
        let copy = |pixel: &[f32; 4], to: &mut [f32]| to.copy_from_slice(pixel);
        let stats = self.render_tiles((camera, lens), (&mut rgba, 4, &mut depth), copy);
        self.picture = Picture { width, height, rgba, depth, stats: RenderStats::default() };
        self.picture.stats = stats?;
        Ok(&self.picture)
    }

    /// Renders the picture that `camera` takes on the CPU, to the caller's memory: `pixels` has
    /// `channels` values for each of its pixels, row after row, which `convert` makes of
    /// premultiplied RGBA in the model's colour space. `depth` is empty, or has a value a pixel, and
    /// then depth is rendered if the settings say so.
    ///
    /// # Errors
    /// Whatever [`render_tile`](pocketnerf_core::render_tile) reports, and [`Error::OutputLength`].
    pub fn render_to<T: Send>(
        &mut self,
        camera: &Camera,
        (pixels, channels, depth): (&mut [T], usize, &mut [f32]),
        convert: impl Fn(&[f32; 4], &mut [T]) + Sync,
    ) -> Result<RenderStats, Error> {
        let n = camera.width as usize * camera.height as usize;
        let lengths = [(n * channels, pixels.len()), (if self.depth { n } else { 0 }, depth.len())];
        for (needed, given) in lengths {
            if needed != given {
                return Err(Error::OutputLength { needed, given });
            }
        }
        self.render_tiles((camera, &Lens::Pinhole), (pixels, channels, depth), convert)
    }

    /// The picture in tiles, on the CPU.
    fn render_tiles<T: Send>(
        &mut self,
        (camera, lens): (&Camera, &Lens),
        (pixels, channels, depth): (&mut [T], usize, &mut [f32]),
        convert: impl Fn(&[f32; 4], &mut [T]) + Sync,
    ) -> Result<RenderStats, Error> {
        let n = self.antialias.rays(camera);
        let Self { model, options, depth: has_depth, workers, .. } = self;
        let (fine, width, height) = (camera.finer(n), camera.width, camera.height);
        let tiles = Tiles::supersampled(width, height, n);
        let parts = parts(tiles, camera, (pixels, channels), depth);
        let worker = || Worker::new(options, *has_depth);
        let stats = workers.map(parts, worker, |worker, part| {
            worker.render(model, (&fine, lens), n, options, (part, channels, &convert))
        })?;
        Ok(stats.into_iter().fold(RenderStats::default(), |mut a, b| {
            a += b;
            a
        }))
    }

    /// The last picture.
    pub(super) fn into_picture(self) -> Picture {
        self.picture
    }
}

/// A tile of a picture, and the pieces of the picture's rows that it covers.
struct Part<'p, T> {
    tile: Tile,
    pixels: Vec<&'p mut [T]>,
    /// Empty if depth is not rendered.
    depth: Vec<&'p mut [f32]>,
}

/// Cuts a picture that `camera` takes into tiles.
fn parts<'p, T>(
    tiles: Tiles,
    camera: &Camera,
    (pixels, channels): (&'p mut [T], usize),
    depth: &'p mut [f32],
) -> Vec<Part<'p, T>> {
    let part = |tile| Part { tile, pixels: Vec::new(), depth: Vec::new() };
    let [w, h] = tiles.size().map(|side| side as usize);
    let mut parts: Vec<Part<'p, T>> = tiles.map(part).collect();
    let row = camera.width.max(1) as usize;
    let first = |y: usize| y / h * row.div_ceil(w);
    for (y, row) in pixels.chunks_mut(channels * row).enumerate() {
        let pieces = row.chunks_mut(channels * w).zip(&mut parts[first(y)..]);
        pieces.for_each(|(piece, part)| part.pixels.push(piece));
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

    /// Renders a tile of which the camera, the finer one, sees `n` × `n` pixels for each.
    fn render<T>(
        &mut self,
        model: &Model<'_>,
        through: (&Camera, &Lens),
        n: u32,
        options: &RenderOptions,
        (part, channels, convert): (Part<'_, T>, usize, &impl Fn(&[f32; 4], &mut [T])),
    ) -> Result<RenderStats, Error> {
        let (fine, width) = (part.tile.finer(n), part.tile.width as usize);
        let rgba = &mut self.rgba[..4 * fine.pixels()];
        let mut depth = (!part.depth.is_empty()).then(|| &mut self.depth[..fine.pixels()]);
        let (scratch, to) = (&mut self.scratch, depth.as_deref_mut());
        let stats = render_through(model, through, fine, options, scratch, rgba, to)?;
        average_tile(part.tile, n, rgba, depth)?;
        for (from, to) in self.rgba.chunks_exact(4 * width).zip(part.pixels) {
            let pixels = from.as_chunks::<4>().0.iter().zip(to.chunks_exact_mut(channels));
            pixels.for_each(|(from, to)| convert(from, to));
        }
        let rows = self.depth.chunks_exact(width).zip(part.depth);
        rows.for_each(|(from, to)| to.copy_from_slice(from));
        Ok(stats)
    }
}
