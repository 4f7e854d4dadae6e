//! Buffers whose size does not depend on the rays.

use pocketnerf_core::Model;
use pocketnerf_core::encoding::HashGrid;
use pocketnerf_core::field::HashGridField;

use super::memory::UNIT_PARTS;
use super::networks::{Networks, PARTS, TILE};
use crate::pack::Packed;
use crate::render::{Error, Gpu};

/// Numbers of `Frame` and of counters: `step.wgsl`.
pub(super) const FRAME_WORDS: usize = 28;
pub(super) const COUNTERS: usize = 8;

/// Buffers whose size does not depend on the rays.
#[derive(Debug)]
pub(super) struct Fixed {
    pub(super) frame: wgpu::Buffer,
    pub(super) weights: wgpu::Buffer,
    pub(super) matrices: wgpu::Buffer,
    pub(super) occupancy: wgpu::Buffer,
    pub(super) cameras: wgpu::Buffer,
    pub(super) counters: wgpu::Buffer,
    pub(super) partial: wgpu::Buffer,
    pub(super) gradient: wgpu::Buffer,
    pub(super) table_of: wgpu::Buffer,
    pub(super) units: wgpu::Buffer,
    pub(super) unit_parts: wgpu::Buffer,
    pub(super) entry_gradients: wgpu::Buffer,
    pub(super) parameters: wgpu::Buffer,
    pub(super) squares: wgpu::Buffer,
    pub(super) largest: wgpu::Buffer,
    pub(super) scales: wgpu::Buffer,
    pub(super) factors: wgpu::Buffer,
    /// The tables as fields read them.
    pub(super) rounded: wgpu::Buffer,
}

impl Fixed {
    pub(super) fn new(
        gpu: &Gpu,
        field: &HashGridField<'_>,
        packed: &Packed,
        networks: &Networks,
        cameras: &[[f32; 3]],
        model: &Model<'_>,
    ) -> Result<Self, Error> {
        use wgpu::BufferUsages as Usage;
        let (read, write) = (Usage::COPY_SRC, Usage::COPY_DST);
        let storage = |what, bytes: usize, more: Usage| {
            gpu.buffer(what, (bytes as u64).max(16), Usage::STORAGE | more)
        };
        let HashGrid { config, .. } = &field.grid;
        let n_levels = config.n_levels as usize;
        let mut tables: Vec<[u32; 8]> = Vec::new();
        let mut start = 0;
        for l in 0..n_levels {
            let level = config.level(l);
            let n = level.entries * config.n_features_per_level;
            let [scale, shift] = [level.scale, level.shift()].map(f32::to_bits);
            tables.push([scale, shift, level.dense_side, level.entries, start, 0, start, n]);
            start += n;
        }
        let n_values = start as usize;
        let resolution = model.occupancy.map_or(8, |occupancy| occupancy.resolution());
        let blocks = (resolution as usize / 8).pow(3);
        let places: Vec<[f32; 4]> = cameras.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
        let tiles = networks.density.products.iter().chain(&networks.color.products);
        let tiles = tiles.map(|product| product.tiles().iter().product::<u32>()).max();
        let partial = tiles.unwrap_or(1) * PARTS * (TILE + 1) * TILE;
        Ok(Self {
            frame: gpu.uniform(&[0; 4 * FRAME_WORDS])?,
            weights: storage("networks", 16 * packed.weights.len(), Usage::empty())?,
            matrices: storage("networks", 16 * networks.n_quads, Usage::empty())?,
            occupancy: storage("cells", 4 * 17 * blocks, write)?,
            cameras: gpu.upload("cameras", bytemuck::cast_slice(&places))?,
            counters: storage("counters", 4 * COUNTERS, read | write)?,
            partial: storage("networks", 4 * partial as usize, Usage::empty())?,
            gradient: storage("networks", 4 * networks.n_parameters, Usage::empty())?,
            table_of: gpu.upload("levels", bytemuck::cast_slice(&tables))?,
            units: gpu.buffer("levels", 4 * n_levels as u64, Usage::STORAGE)?,
            unit_parts: storage("levels", 16 * n_levels * UNIT_PARTS as usize, Usage::empty())?,
            entry_gradients: storage("hash tables", 4 * n_values, write)?,
            parameters: storage("hash tables", 4 * n_values, read | write)?,
            squares: storage("hash tables", 4 * n_values, read | write)?,
            largest: storage("levels", 4 * n_levels, write)?,
            scales: gpu.buffer("levels", 8 * n_levels as u64, Usage::STORAGE | read | write)?,
            factors: storage("levels", 4 * n_levels, Usage::empty())?,
            rounded: storage("hash tables", n_values.next_multiple_of(4), Usage::empty())?,
        })
    }
}
