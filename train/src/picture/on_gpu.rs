//! Whole pictures by a GPU, as the CPU's renderer has them: through lenses, and of several rays
//! a pixel.

use pocketnerf_core::render::{RenderStats, average_tile};
use pocketnerf_core::{Camera, Model, Ray, RenderOptions, Tile};
use pocketnerf_gpu::{Error, Gpu, Renderer};
use rayon::prelude::*;

use super::Picture;
use crate::lens::Lens;

/// Rays of a part of a picture at most: 80 MB.
const MOST_RAYS: usize = 1 << 22;

/// A model on a GPU.
#[derive(Debug)]
pub(super) struct OnGpu {
    renderer: Renderer,
    rays: Vec<Ray>,
    rgba: Vec<f32>,
    depth: Vec<f32>,
}

impl OnGpu {
    pub(super) fn new(
        gpu: &Gpu,
        model: &Model<'_>,
        options: &RenderOptions,
    ) -> Result<Self, Error> {
        let renderer = Renderer::new(gpu, model, options)?;
        Ok(Self { renderer, rays: Vec::new(), rgba: Vec::new(), depth: Vec::new() })
    }

    /// Fills `picture`, whose `depth` is empty where it is not wanted, by `n` rays along each
    /// side of a pixel.
    pub(super) fn render(
        &mut self,
        camera: &Camera,
        lens: &Lens,
        n: u32,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let width = camera.width as usize;
        let per_row = (width * n as usize * n as usize).max(1);
        let rows = (MOST_RAYS / per_row).max(1);
        picture.stats = RenderStats::default();
        for first in (0..camera.height as usize).step_by(rows) {
            let rows = rows.min(camera.height as usize - first);
            let mut part = *camera;
            part.height = rows as u32;
            part.center[1] -= first as f32;
            let pixels = first * width..(first + rows) * width;
            let rgba = &mut picture.rgba[4 * pixels.start..4 * pixels.end];
            let depth = match picture.depth.is_empty() {
                true => None,
                false => Some(&mut picture.depth[pixels]),
            };
            picture.stats += self.render_part(&part, lens, n, rgba, depth)?;
        }
        Ok(())
    }

    /// Fills the pixels of a small picture.
    fn render_part(
        &mut self,
        camera: &Camera,
        lens: &Lens,
        n: u32,
        rgba: &mut [f32],
        depth: Option<&mut [f32]>,
    ) -> Result<RenderStats, Error> {
        let fine = camera.finer(n);
        let rendered = match lens {
            Lens::Pinhole => self.renderer.render(&fine)?,
            _ => {
                let ray = |i: u32| {
                    let (x, y) = (i % fine.width, i / fine.width);
                    lens.ray(&fine, x as f32 + 0.5, y as f32 + 0.5)
                };
                (0..fine.width * fine.height)
                    .into_par_iter()
                    .map(ray)
                    .collect_into_vec(&mut self.rays);
                self.renderer.render_rays(&self.rays, fine.width, fine.axis())?
            }
        };
        let rays = u64::from(rendered.width) * u64::from(rendered.height);
        let stats = RenderStats { rays, samples: rendered.samples, hits: rendered.hits };
        if n == 1 {
            rgba.copy_from_slice(&rendered.rgba);
            if let Some(depth) = depth {
                depth.copy_from_slice(&rendered.depth);
            }
            return Ok(stats);
        }
        self.rgba.clone_from(&rendered.rgba);
        self.depth.clone_from(&rendered.depth);
        let tile = Tile { x: 0, y: 0, width: camera.width, height: camera.height };
        average_tile(tile, n, &mut self.rgba, Some(&mut self.depth))?;
        rgba.copy_from_slice(&self.rgba[..rgba.len()]);
        if let Some(depth) = depth {
            depth.copy_from_slice(&self.depth[..depth.len()]);
        }
        Ok(stats)
    }
}
