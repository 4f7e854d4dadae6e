//! Whole pictures of a model, and their files.

mod antialias;
mod depths;
mod device;
pub mod exr_file;
pub mod image_file;
mod normals;
#[cfg(feature = "gpu")]
mod on_gpu;
mod painter;
mod progressive;
mod renderer;

use pocketnerf_core::render::{RenderStats, Tiles};
use pocketnerf_core::{Camera, Display, Error, Model, RenderOptions, SimdLevel, Tuning, pixel};

pub use antialias::Antialias;
pub(crate) use depths::depths;
use depths::ray;
pub use device::Device;
pub use normals::normals;
pub use painter::Painter;
pub use progressive::Progressive;
pub use renderer::Renderer;

/// Where the samples of a ray lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Equal steps through occupied cells, until almost no light is left.
    #[default]
    Occupancy,
    /// A fixed number per ray, the model's own or that of the original NeRF: evenly spaced,
    /// then where these have weight. [`Settings::quality`] changes nothing.
    Hierarchical,
}

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// Skip empty space.
    pub skip: bool,
    /// From 0, the fastest, to 1, the finest: see [`Model::detail`].
    pub quality: f32,
    /// Whether depth is rendered.
    pub depth: bool,
    /// How much is worked on at a time.
    pub tuning: Tuning,
    /// Where the samples of a ray lie.
    pub sampling: Sampling,
    /// How many rays are cast a pixel.
    pub antialias: Antialias,
}

impl Default for Settings {
    /// As fast as this machine can, in the usual quality, one ray a pixel, without depth.
    fn default() -> Self {
        Self {
            simd: SimdLevel::detect(),
            skip: true,
            quality: 0.5,
            depth: false,
            tuning: Tuning::FAST,
            sampling: Sampling::Occupancy,
            antialias: Antialias::Off,
        }
    }
}

impl Settings {
    /// The core's options; how many rays a pixel has is not among them.
    pub fn options(&self, model: &Model<'_>) -> RenderOptions {
        let Self { simd, skip, quality, tuning, .. } = *self;
        let options = RenderOptions {
            skip,
            detail: model.detail(quality),
            ..RenderOptions::new(model, simd, tuning)
        };
        match self.sampling {
            Sampling::Occupancy => options,
            Sampling::Hierarchical => options.with_sampling(model.hierarchical_sampling()),
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
    /// Premultiplied RGBA in the model's colour space, four values a pixel, without
    /// background.
    pub rgba: Vec<f32>,
    /// Expected Euclidean distance, scene units, of all rays of a pixel; infinite where nothing
    /// is. Empty if depth was not rendered.
    pub depth: Vec<f32>,
    /// What it took.
    pub stats: RenderStats,
}

impl Picture {
    /// RGB over a background, three values a pixel, all in the model's colour space.
    #[must_use]
    pub fn over(&self, background: [f32; 3]) -> Vec<f32> {
        let pixels = self.rgba.as_chunks::<4>().0.iter();
        pixels.flat_map(|rgba| pixel::over(*rgba, background)).collect()
    }

    /// 8-bit sRGB over the background of a model's display, three values a pixel.
    #[must_use]
    pub fn rgb8(&self, display: &Display) -> Vec<u8> {
        self.rgba.as_chunks::<4>().0.iter().flat_map(|rgba| display.rgb8(*rgba)).collect()
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
/// Whatever [`render_tile`](pocketnerf_core::render_tile) reports.
pub fn render(model: &Model<'_>, camera: &Camera, settings: &Settings) -> Result<Picture, Error> {
    let mut renderer = Renderer::new(model, settings);
    renderer.render(camera)?;
    Ok(renderer.into_picture())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trainer::{Length, TrainConfig};

    #[test]
    fn a_thread_renders_in_less_than_a_mebibyte() {
        // Of a table of half a mebibyte, each of two threads has half.
        const TABLE: usize = (1 << 19) / 2;
        let long = TrainConfig::hash_grid().for_length(Length::Seconds(1200.0));
        for config in [TrainConfig::hash_grid(), long.clone(), long.for_speed()] {
            let trainable = config.field.kind().build(1.0);
            let parameters = vec![0.0; trainable.layout().len()];
            let field = trainable.view(&parameters).unwrap();
            let tuning = Tuning::FAST;
            let scratch = pocketnerf_core::scratch::scratch_len(field.limits(), tuning);
            let tile = 4 * Tiles::MOST_PIXELS;
            let bytes = size_of::<f32>() * (scratch + tile) + TABLE;
            assert!(bytes <= 1 << 20, "{bytes}");
        }
    }
}
