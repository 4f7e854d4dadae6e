//! Tiles of a picture by a GPU.

use std::sync::{Mutex, PoisonError};

use pocketnerf_core::render::RenderStats;
use pocketnerf_core::{Camera, Model, RenderOptions, SimdLevel, Tile, Tuning};
use pocketnerf_gpu::{Error, Gpu, Picture, Renderer};

/// A model on a GPU, or why it is not there any more.
#[derive(Debug)]
pub(super) struct OnGpu {
    name: String,
    state: Mutex<Result<Renderer, Error>>,
}

impl OnGpu {
    pub(super) fn new(gpu: &Gpu, model: &Model<'_>) -> Self {
        let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
        let state = Mutex::new(Renderer::new(gpu, model, &options));
        Self { name: gpu.name().to_owned(), state }
    }

    /// What paints, and why if it is not the GPU.
    pub(super) fn status(&self) -> String {
        match &*self.state.lock().unwrap_or_else(PoisonError::into_inner) {
            Ok(_) => format!("on {}", self.name),
            Err(why) => format!("on the CPU: {why}"),
        }
    }

    /// Renders the rows of a picture that `tiles` lie in, and hands them over with the number of
    /// the first; `None` where the GPU does not work.
    pub(super) fn rows<T>(
        &self,
        camera: &Camera,
        options: &RenderOptions,
        tiles: &[Tile],
        take: impl FnOnce(&Picture, u32) -> T,
    ) -> Option<(T, RenderStats)> {
        let first = tiles.iter().map(|tile| tile.y).min()?;
        let end = tiles.iter().map(|tile| tile.y + tile.height).max()?;
        let mut part = Camera { height: end - first, ..*camera };
        part.center[1] -= first as f32;
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let renderer = state.as_mut().ok()?;
        renderer.set_detail(options.detail);
        match renderer.render(&part) {
            Ok(picture) => {
                let rays = u64::from(picture.width) * u64::from(picture.height);
                let stats = RenderStats { rays, samples: picture.samples, hits: picture.hits };
                Some((take(picture, first), stats))
            }
            Err(why) => {
                *state = Err(why);
                None
            }
        }
    }
}
