//! Memory of a step's rays and samples, and what kernels bind of it.

use super::fixed::Fixed;
use super::kernel::Pipeline;
use super::networks::{BLOCK, Chain, Networks, Product, Shape};
use super::pipelines::Pipelines;
use crate::render::{Error, Gpu};

/// Samples of a chunk: `step.wgsl`.
const CHUNK: u32 = 16;
/// Parts of the samples whose gradients are summed up: `tables.wgsl`.
pub(super) const UNIT_PARTS: u32 = 64;
/// Rays of a workgroup of `drop`: `back.wgsl`.
const GROUP: u64 = 64;
/// Bytes of a number, and of four.
const NUMBER: u64 = 4;
const QUAD: u64 = 16;

/// How much there is room for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Room {
    /// Rays.
    pub(super) rays: u32,
    /// Columns of the colour network.
    pub(super) columns: u32,
    /// Chunks of samples.
    pub(super) chunks: u32,
    /// Samples that are passed back.
    pub(super) kept: u32,
    /// How many times as many samples as usual that is.
    pub(super) growth: u32,
}

impl Room {
    /// For so many rays and columns and about so many samples, or `growth` times as many.
    pub(super) fn new(samples: u32, rays: u32, columns: u32, growth: u32) -> Self {
        let chunks = (2 * samples / CHUNK + rays).saturating_mul(growth);
        // The roulette passes back half of them at most, about.
        let kept = (samples / 8 * 5).saturating_mul(growth);
        Self { rays, columns, chunks, kept, growth }
    }

    /// How many times as much room so many chunks and samples take.
    pub(super) const fn growth(&self, chunks: u32, kept: u32) -> u32 {
        let [chunks, kept] = [chunks.div_ceil(self.chunks), kept.div_ceil(self.kept)];
        if chunks > kept { chunks } else { kept }
    }

    /// Whether all that fits into another room fits here.
    pub(super) const fn holds(&self, other: &Self) -> bool {
        self.rays >= other.rays
            && self.columns >= other.columns
            && self.chunks >= other.chunks
            && self.kept >= other.kept
    }
}

/// Buffers of a step, and the groups of buffers that kernels bind.
#[derive(Debug)]
pub(super) struct Memory {
    pub(super) room: Room,
    pub(super) rays: wgpu::Buffer,
    pub(super) results: wgpu::Buffer,
    pub(super) groups: Groups,
}

/// What each kernel binds.
#[derive(Debug)]
pub(super) struct Groups {
    pub(super) trace: wgpu::BindGroup,
    pub(super) shade: wgpu::BindGroup,
    pub(super) color: Layers,
    pub(super) loss: wgpu::BindGroup,
    pub(super) drop: wgpu::BindGroup,
    pub(super) scan: wgpu::BindGroup,
    pub(super) gather: wgpu::BindGroup,
    pub(super) encode_again: wgpu::BindGroup,
    pub(super) density: Layers,
    pub(super) sum_units: wgpu::BindGroup,
    pub(super) find_units: wgpu::BindGroup,
    pub(super) scatter: wgpu::BindGroup,
}

/// A layer's group of buffers, and how many blocks of rows it writes.
pub(super) type Layer = (wgpu::BindGroup, u32);

/// What the kernels of a network bind.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) forward: Vec<Layer>,
    pub(super) backward: Vec<Layer>,
    /// Of the gradient of each layer's weights: sums of parts, then of all.
    pub(super) products: Vec<(wgpu::BindGroup, wgpu::BindGroup, Product)>,
}

impl Memory {
    pub(super) fn new(
        gpu: &Gpu,
        (pipelines, networks): (&Pipelines, &Networks),
        fixed: &Fixed,
        per_sample: u32,
        room: Room,
    ) -> Result<Self, Error> {
        use wgpu::BufferUsages as Usage;
        let storage = |what, n: u64, bytes: u64, more: Usage| {
            gpu.buffer(what, (n * bytes).max(QUAD), Usage::STORAGE | more)
        };
        let [n_rays, columns, chunks, kept] =
            [room.rays, room.columns, room.chunks, room.kept].map(u64::from);
        let per_sample = u64::from(per_sample);
        let [sample_rows, ray_rows] = networks.n_rows.map(u64::from);
        let none = Usage::empty();
        let rays = storage("rays", n_rays, 4 * QUAD, Usage::COPY_DST)?;
        let traced = storage("rays", n_rays * per_sample, QUAD, none)?;
        let n_samples = chunks * u64::from(CHUNK);
        let samples = storage("samples", n_samples * per_sample, QUAD, none)?;
        let links = storage("chunks of samples", chunks, NUMBER, none)?;
        let ray_rows = storage("rows of rays", columns * ray_rows, NUMBER, none)?;
        let sample_rows = storage("rows of samples", kept * sample_rows, NUMBER, none)?;
        let results = storage("rays", n_rays, QUAD, Usage::COPY_SRC)?;
        let offsets = storage("rays", n_rays, NUMBER, none)?;
        let group_offsets = storage("rays", n_rays.div_ceil(GROUP), NUMBER, none)?;
        let f = fixed;
        let bound =
            |pipeline: &Pipeline, buffers: &[(u32, &wgpu::Buffer)]| pipeline.group(gpu, buffers);
        let layers = |chain: &Chain, is_rays: bool| {
            let rows = if is_rays { &ray_rows } else { &sample_rows };
            let [dense, outer] = match is_rays {
                true => [&pipelines.dense_rays, &pipelines.outer_rays],
                false => [&pipelines.dense_samples, &pipelines.outer_samples],
            };
            let group = |pipeline: &Pipeline, own: &[(u32, &wgpu::Buffer)]| {
                let mut all = vec![(0, &f.frame)];
                all.extend((!is_rays).then_some((10, &f.counters)));
                all.extend_from_slice(own);
                bound(pipeline, &all)
            };
            let layer = |shape: &Shape| -> Result<Layer, Error> {
                let own = gpu.uniform(bytemuck::bytes_of(shape))?;
                let buffers = [(20, &own), (21, &f.matrices), (22, rows)];
                Ok((group(dense, &buffers)?, shape.n_out / BLOCK))
            };
            let product = |product: &Product| -> Result<_, Error> {
                let own = gpu.uniform(bytemuck::bytes_of(product))?;
                let sums = group(outer, &[(23, rows), (24, &own), (25, &f.partial)])?;
                let buffers = [(24, &own), (25, &f.partial), (26, &f.gradient)];
                Ok((sums, bound(&pipelines.reduce, &buffers)?, *product))
            };
            Ok::<_, Error>(Layers {
                forward: chain.forward.iter().map(layer).collect::<Result<_, _>>()?,
                backward: chain.backward.iter().map(layer).collect::<Result<_, _>>()?,
                products: chain.products.iter().map(product).collect::<Result<_, _>>()?,
            })
        };
        let p = pipelines;
        let groups = Groups {
            trace: bound(
                &p.trace,
                &[
                    (0, &f.frame),
                    networks.rows.together.map_or((1, &f.weights), |_| (21, &f.matrices)),
                    (2, &f.rounded),
                    (3, &f.occupancy),
                    (4, &f.factors),
                    (5, &rays),
                    (6, &traced),
                    (7, &samples),
                    (8, &links),
                    (9, &f.counters),
                ],
            )?,
            shade: bound(
                &p.shade,
                &[(0, &f.frame), (5, &rays), (6, &traced), (11, &ray_rows), (15, &f.cameras)],
            )?,
            color: layers(&networks.color, true)?,
            loss: bound(
                &p.loss,
                &[(0, &f.frame), (5, &rays), (6, &traced), (11, &ray_rows), (13, &results)],
            )?,
            drop: bound(
                &p.drop,
                &[
                    (0, &f.frame),
                    (5, &rays),
                    (6, &traced),
                    (7, &samples),
                    (8, &links),
                    (11, &ray_rows),
                    (13, &results),
                    (14, &offsets),
                    (16, &group_offsets),
                ],
            )?,
            scan: bound(&p.scan, &[(0, &f.frame), (9, &f.counters), (16, &group_offsets)])?,
            gather: bound(
                &p.gather,
                &[
                    (0, &f.frame),
                    (6, &traced),
                    (7, &samples),
                    (8, &links),
                    (12, &sample_rows),
                    (14, &offsets),
                    (16, &group_offsets),
                ],
            )?,
            encode_again: bound(
                &p.encode_again,
                &[
                    (0, &f.frame),
                    (2, &f.rounded),
                    (4, &f.factors),
                    (10, &f.counters),
                    (12, &sample_rows),
                ],
            )?,
            density: layers(&networks.density, false)?,
            sum_units: bound(
                &p.sum_units,
                &[(0, &f.frame), (10, &f.counters), (12, &sample_rows), (42, &f.unit_parts)],
            )?,
            find_units: bound(&p.find_units, &[(31, &f.units), (42, &f.unit_parts)])?,
            scatter: bound(
                &p.scatter,
                &[
                    (0, &f.frame),
                    (10, &f.counters),
                    (12, &sample_rows),
                    (30, &f.table_of),
                    (31, &f.units),
                    (32, &f.entry_gradients),
                ],
            )?,
        };
        Ok(Self { room, rays, results, groups })
    }
}
