//! Pictures of a model, tiles on all threads.

pub mod cells;
pub mod modes;
#[cfg(feature = "gpu")]
mod on_gpu;
pub mod picture;

use std::sync::{Arc, Mutex, PoisonError};

use pocketnerf_core::query::Depth;
use pocketnerf_core::render::{RenderStats, Tiles};
use pocketnerf_core::{
    Camera, ColorSpace, Error, Model, Probe, RenderOptions, SimdLevel, Tile, Tuning, pixel,
    render_tile,
};
use rayon::ThreadPool;
use rayon::prelude::*;

use cells::Cells;
use modes::{Mode, Range};
use picture::{Picture, pack};

/// A picture to paint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// View and size.
    pub camera: Camera,
    /// What it shows.
    pub mode: Mode,
    /// From 0, the fastest, to 1, the finest: see [`Model::detail`].
    pub quality: f32,
}

impl Shot {
    /// The same view in a picture of another size.
    #[must_use]
    pub fn sized(self, [width, height]: [u32; 2]) -> Self {
        let own = self.camera;
        let [across, down] = [width as f32 / own.width as f32, height as f32 / own.height as f32];
        let camera = Camera {
            width,
            height,
            focal: [own.focal[0] * across, own.focal[1] * down],
            center: [own.center[0] * across, own.center[1] * down],
            ..own
        };
        Self { camera, ..self }
    }
}

/// Paints pictures of a model.
#[derive(Debug)]
pub struct Painter<'m> {
    model: &'m Model<'m>,
    simd: SimdLevel,
    /// `None` for spaces other than boxes.
    probe: Option<Probe<'m>>,
    cells: Cells<'m>,
    occupied: [[f32; 3]; 2],
    pool: Arc<ThreadPool>,
    /// Memory of idle threads.
    idle: Mutex<Vec<Worker>>,
    #[cfg(feature = "gpu")]
    gpu: Option<on_gpu::OnGpu>,
}

/// The memory of a thread.
#[derive(Debug)]
struct Worker {
    scratch: Vec<f32>,
    rgba: Vec<f32>,
    depth: Vec<f32>,
}

impl<'m> Painter<'m> {
    /// Paints `model` on `threads` threads; 0: one per core.
    ///
    /// # Errors
    /// One line, if the system refuses the threads.
    pub fn new(model: &'m Model<'m>, threads: usize) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| format!("{threads} threads: {e}; give --threads 1"))?;
        Ok(Self::in_pool(model, Arc::new(pool)))
    }

    /// Paints `model` on the threads of a pool.
    #[must_use]
    pub fn in_pool(model: &'m Model<'m>, pool: Arc<ThreadPool>) -> Self {
        let (simd, cells) = (SimdLevel::detect(), Cells::new(model));
        Self {
            model,
            simd,
            probe: Probe::new(model, simd, Tuning::FAST).ok(),
            cells,
            occupied: cells.bounds(),
            pool,
            idle: Mutex::default(),
            #[cfg(feature = "gpu")]
            gpu: None,
        }
    }

    /// Paints colours and depths on `gpu`; on the CPU where it fails.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn on(mut self, gpu: &pocketnerf_gpu::Gpu) -> Self {
        self.gpu = Some(on_gpu::OnGpu::new(gpu, self.model));
        self
    }

    /// Which GPU paints, or why none does; `None` where none was asked for.
    #[must_use]
    pub fn gpu(&self) -> Option<String> {
        #[cfg(feature = "gpu")]
        return self.gpu.as_ref().map(on_gpu::OnGpu::status);
        #[cfg(not(feature = "gpu"))]
        None
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> &'m Model<'m> {
        self.model
    }

    /// Number of threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Whether the model can be shown in this mode: normals need a box.
    #[must_use]
    pub const fn shows(&self, mode: Mode) -> bool {
        self.probe.is_some() || !matches!(mode, Mode::Normals)
    }

    /// The range of depths that the colour map covers.
    #[must_use]
    pub fn range(&self, camera: &Camera) -> Range {
        Range::seen(camera, &self.model.space, self.occupied)
    }

    /// Paints a whole picture.
    ///
    /// # Errors
    /// Those of [`paint`](Self::paint).
    pub fn picture(&self, shot: &Shot) -> Result<(Picture, RenderStats), Error> {
        let mut picture = Picture::new(shot.camera.width, shot.camera.height);
        let stats = self.paint(shot, Tiles::new(picture.width, picture.height), &mut picture)?;
        Ok((picture, stats))
    }

    /// Paints some tiles of a picture.
    ///
    /// # Errors
    /// Those of [`render_tile`] and [`Probe`].
    pub fn paint(
        &self,
        shot: &Shot,
        tiles: impl Iterator<Item = Tile> + Send,
        picture: &mut Picture,
    ) -> Result<RenderStats, Error> {
        let quality = self.model.detail(shot.quality);
        let options = RenderOptions::new(self.model, self.simd, Tuning::FAST);
        let options = RenderOptions { detail: quality, ..options };
        let range = self.range(&shot.camera);
        let tiles: Vec<Tile> = tiles.collect();
        #[cfg(feature = "gpu")]
        if let Some(stats) = self.paint_on_gpu(shot, &options, &tiles, &range, picture) {
            return Ok(stats);
        }
        let paint = |tile| {
            let mut worker = self.take(&options);
            let painted = self.paint_tile(shot, tile, &options, &range, &mut worker);
            self.idle().push(worker);
            Ok((tile, painted?))
        };
        // A bridge keeps the order of tiles: neighbours are painted at the same time.
        let painted: Result<Vec<_>, Error> =
            self.pool.install(|| tiles.into_iter().par_bridge().map(paint).collect());
        let mut all = RenderStats::default();
        for (tile, (pixels, stats)) in painted? {
            picture.put(tile, &pixels);
            all += stats;
        }
        Ok(all)
    }

    /// `None` where the GPU does not do it.
    #[cfg(feature = "gpu")]
    fn paint_on_gpu(
        &self,
        shot: &Shot,
        options: &RenderOptions,
        tiles: &[Tile],
        range: &Range,
        picture: &mut Picture,
    ) -> Option<RenderStats> {
        let gpu = self.gpu.as_ref()?;
        if !matches!(shot.mode, Mode::Colour | Mode::Depth) {
            return None;
        }
        let painted = gpu.rows(&shot.camera, options, tiles, |rendered, first| {
            let rgba = rendered.rgba.as_chunks::<4>().0;
            for tile in tiles {
                let row = |y: u32| (y - first) as usize * rendered.width as usize;
                let pixels = (tile.y..tile.y + tile.height).flat_map(|y| {
                    let begin = row(y) + tile.x as usize;
                    begin..begin + tile.width as usize
                });
                let color = |i: usize| self.color(shot.mode, &rgba[i], rendered.depth[i], range);
                picture.put(*tile, &pixels.map(color).collect::<Vec<_>>());
            }
        });
        painted.map(|((), stats)| stats)
    }

    /// The colour of a rendered pixel.
    fn color(&self, mode: Mode, rgba: &[f32; 4], depth: f32, range: &Range) -> u32 {
        let display = &self.model.display;
        if mode == Mode::Colour {
            return pack(display.rgb8(*rgba));
        }
        let alpha = rgba[3];
        let [r, g, b] = range.color(depth).map(|c| c * alpha);
        // Colours of the other modes are sRGB.
        let over = pixel::over([r, g, b, alpha], display.srgb_background());
        pack(pixel::rgb8(over, ColorSpace::Srgb))
    }

    /// Runs other work on the painter's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    fn paint_tile(
        &self,
        shot: &Shot,
        tile: Tile,
        options: &RenderOptions,
        range: &Range,
        worker: &mut Worker,
    ) -> Result<(Vec<u32>, RenderStats), Error> {
        let Worker { scratch, rgba, depth } = worker;
        let (rgba, depth) = (&mut rgba[..4 * tile.pixels()], &mut depth[..tile.pixels()]);
        let (camera, model) = (&shot.camera, self.model);
        // Colours of the other modes are sRGB.
        let behind = model.display.srgb_background();
        let finish = |rgb| pack(pixel::rgb8(rgb, ColorSpace::Srgb));
        let mut stats = RenderStats::default();
        let pixels = match (shot.mode, &self.probe) {
            (Mode::Colour, _) => {
                stats = render_tile(model, camera, tile, options, scratch, rgba, None)?;
                let rgba = rgba.as_chunks::<4>().0.iter();
                rgba.map(|rgba| self.color(shot.mode, rgba, 0.0, range)).collect()
            }
            (Mode::Depth, _) => {
                stats = render_tile(model, camera, tile, options, scratch, rgba, Some(depth))?;
                let pixels = rgba.as_chunks::<4>().0.iter().zip(depth);
                pixels.map(|(rgba, depth)| self.color(shot.mode, rgba, *depth, range)).collect()
            }
            (Mode::Normals, Some(probe)) => {
                stats.rays = tile.pixels() as u64;
                let rays: Vec<_> = rays(camera, tile).collect();
                let mut normals = vec![[0.0; 3]; rays.len()];
                probe.depths(&rays, Depth::Median, None, scratch, depth)?;
                probe.surface_normals(&rays, depth, scratch, &mut normals)?;
                let color = |(n, t): ([f32; 3], &f32)| match t.is_finite() {
                    true => finish(n.map(|v| 0.5 + 0.5 * v)),
                    false => finish(behind),
                };
                normals.into_iter().zip(&*depth).map(color).collect()
            }
            (Mode::Normals, None) => {
                return Err(Error::Unsupported("normals: its space is no box"));
            }
            (Mode::Occupancy, _) => {
                stats.rays = tile.pixels() as u64;
                let color = |ray| self.cells.first(&ray).map_or(behind, |face| cells::color(&face));
                rays(camera, tile).map(|ray| finish(color(ray))).collect()
            }
        };
        Ok((pixels, stats))
    }

    fn take(&self, options: &RenderOptions) -> Worker {
        let idle = self.idle().pop();
        idle.unwrap_or_else(|| {
            let probe = self.probe.map_or(0, |probe| probe.scratch_len());
            let n = Tiles::MOST_PIXELS;
            Worker {
                scratch: vec![0.0; options.scratch_len().max(probe)],
                rgba: vec![0.0; 4 * n],
                depth: vec![0.0; n],
            }
        })
    }

    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Worker>> {
        // The memory may hold anything, so it cannot be poisoned.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The rays of a tile's pixels.
fn rays(camera: &Camera, tile: Tile) -> impl Iterator<Item = pocketnerf_core::Ray> + '_ {
    let Tile { x, y, width, height } = tile;
    let pixels = (y..y + height).flat_map(move |y| (x..x + width).map(move |x| (x, y)));
    pixels.map(|(x, y)| camera.ray(x as f32 + 0.5, y as f32 + 0.5))
}
