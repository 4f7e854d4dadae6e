//! A GPU's memory for pixels.

use pocketnerf_core::Ray;
use wgpu::BufferUsages as Usage;

use super::clock::Clock;
use super::{Error, Gpu};

/// Bytes of a pixel: its colour, then its depth and samples.
pub(super) const COLOR: u64 = 16;
pub(super) const DISTANCE: u64 = 8;
/// Bytes of a ray.
const RAY: u64 = size_of::<Ray>() as u64;

/// Room for what goes in and out.
#[derive(Debug)]
pub(super) struct Band {
    pixels: u64,
    has_rays: bool,
    pub(super) rays: wgpu::Buffer,
    pub(super) colors: wgpu::Buffer,
    pub(super) distances: wgpu::Buffer,
    /// Both, where the CPU can read them, and when the GPU began and ended.
    pub(super) read: wgpu::Buffer,
    pub(super) group: wgpu::BindGroup,
}

impl Band {
    /// Bytes of when the GPU began and ended.
    pub(super) const TIMES: u64 = Clock::bytes(1);

    /// Room for so many pixels of programs that read `inputs`, and leave each other `mean`
    /// bytes a pixel.
    pub(super) fn new(
        gpu: &Gpu,
        pipeline: &wgpu::ComputePipeline,
        inputs: [&wgpu::Buffer; 4],
        pixels: u64,
        has_rays: bool,
        mean: u64,
    ) -> Result<Self, Error> {
        let out = Usage::STORAGE | Usage::COPY_SRC;
        let n_rays = if has_rays { pixels } else { 1 };
        let rays = gpu.buffer("rays", RAY * n_rays, Usage::STORAGE | Usage::COPY_DST)?;
        let colors = gpu.buffer("pixels", COLOR * pixels, out)?;
        let distances = gpu.buffer("pixels", DISTANCE * pixels, out)?;
        let means = gpu.buffer("pixels", (mean * pixels).max(16), Usage::STORAGE)?;
        let all = (COLOR + DISTANCE) * pixels + Self::TIMES;
        let read = gpu.buffer("pixels", all, Usage::MAP_READ | Usage::COPY_DST)?;
        let [frame, weights, tables, cells] = inputs;
        let buffers = [frame, weights, tables, cells, &rays, &colors, &distances, &means];
        let group = gpu.group(pipeline, (0..).zip(buffers))?;
        Ok(Self { pixels, has_rays, rays, colors, distances, read, group })
    }

    /// Whether so many pixels fit.
    pub(super) const fn fits(&self, pixels: u64, has_rays: bool) -> bool {
        self.pixels >= pixels && (self.has_rays || !has_rays)
    }
}
