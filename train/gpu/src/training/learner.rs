//! A field that learns on a GPU.

use std::sync::Mutex;

use pocketnerf_core::Model;

use super::fixed::{COUNTERS, FRAME_WORDS, Fixed};
use super::following::Following;
use super::kernel::Program;
use super::memory::{Memory, Room, UNIT_PARTS};
use super::networks::{Networks, PARTS};
use super::pipelines::Pipelines;
use super::plan::Plan;
use super::sequence::{Sequence, Watch};
use super::step::{PixelNumbers, Settings};
use super::tables::{Sums, TableGroups};
use super::under_way::{UnderWay, Used};
use crate::pack::pack_cells;
use crate::render::{Error, Gpu};
use crate::shader::Together;

/// Rays that are asked for colours between the cameras, and directions of each: `inputs.wgsl`.
const EVERY: u32 = 16;
const ASKED: u32 = 5;
/// Workgroups of kernels whose invocations take several columns.
pub(super) const MOST_GROUPS: u32 = 2048;
/// Values that a workgroup sums up: `dense.wgsl`.
const SUMS: u32 = 32;

/// A field that learns: a hash grid whose colours are those of rays, with tables of bytes.
#[derive(Debug)]
pub struct Learner {
    pub(super) gpu: Gpu,
    pub(super) pipelines: Pipelines,
    networks: Networks,
    pub(super) following: Following,
    pub(super) fixed: Fixed,
    pub(super) groups: TableGroups,
    pub(super) sums: Option<Sums>,
    pub(super) memory: Memory,
    /// Buffers for results that no step has.
    pub(super) free: Vec<wgpu::Buffer>,
    /// A buffer for what is learnt, where the CPU can read it.
    pub(super) downloads: Mutex<Option<wgpu::Buffer>>,
    /// Quads of a ray and of a sample.
    per_sample: u32,
    /// Values of each level's table.
    pub(super) tables: Vec<u32>,
    n_features: u32,
    /// The cells that were uploaded last, as the CPU has them.
    cells: [Vec<u8>; 2],
    cameras: u32,
    /// Samples of a step, about.
    pub(super) samples: u32,
    /// How many times as many there is room for as usual.
    pub(super) growth: u32,
    pub(super) used: Used,
    pub(super) watch: Option<Watch>,
}

impl Learner {
    /// For fields like that of `model`, whose tables are bytes, seen by cameras at these places,
    /// with about so many samples a step. Nothing is learnt of the model's values:
    /// [`set_learnt`](Self::set_learnt) says them.
    ///
    /// # Errors
    /// [`Error::Untrainable`] for other fields, [`Error::Device`] or [`Error::TooLarge`].
    pub fn new(
        gpu: &Gpu,
        model: &Model<'_>,
        cameras: &[[f32; 3]],
        samples: u32,
    ) -> Result<Self, Error> {
        let Plan { field, packed, networks, n_feature_quads, source } = Plan::new(model)?;
        let program = Program::new(gpu, source)?;
        let pipelines = Pipelines::new(&program)?;
        let fixed = Fixed::new(gpu, field, &packed, &networks, cameras, model)?;
        let per_sample = 2 + n_feature_quads;
        let room = Room::new(samples, samples / 8, samples / 5, 1);
        let memory = Memory::new(gpu, (&pipelines, &networks), &fixed, per_sample, room)?;
        let n_features = field.grid.config.n_features_per_level;
        let n_levels = field.grid.config.n_levels as usize;
        let tables = (0..n_levels).map(|l| field.grid.config.level(l).entries * n_features);
        Ok(Self {
            gpu: gpu.clone(),
            groups: TableGroups::new(gpu, &pipelines, &fixed)?,
            sums: None,
            following: Following::new(gpu, &pipelines, &fixed, &networks, &field.decoder)?,
            pipelines,
            networks,
            fixed,
            memory,
            free: Vec::new(),
            downloads: Mutex::new(None),
            per_sample,
            tables: tables.collect(),
            n_features,
            cells: Default::default(),
            cameras: cameras.len() as u32,
            samples,
            growth: 1,
            used: Used::default(),
            watch: None,
        })
    }

    /// From now on steps say how long each kernel takes, where the GPU can tell; they take longer.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn watch(&mut self) -> Result<(), Error> {
        if self.watch.is_none() {
            self.watch = Watch::new(&self.gpu)?;
        }
        Ok(())
    }

    /// Has the GPU take a step, behind those that are under way: parameters are new after it.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn begin(
        &mut self,
        pixels: &[PixelNumbers],
        settings: &Settings<'_>,
    ) -> Result<UnderWay, Error> {
        let n_rays = pixels.len() as u32;
        let groups = if settings.between_views { n_rays.div_ceil(EVERY) } else { 0 };
        let columns = n_rays + ASKED * groups;
        self.show_cells(settings);
        if settings.average && self.sums.is_none() {
            self.sums = Some(self.no_sums()?);
        }
        self.make_room(n_rays, columns)?;
        let read = self.place_to_read(n_rays)?;
        let frame = self.frame(settings, [n_rays, columns]);
        let queue = self.gpu.queue();
        queue.write_buffer(&self.memory.rays, 0, bytemuck::cast_slice(pixels));
        queue.write_buffer(&self.fixed.frame, 0, bytemuck::cast_slice(&frame));
        queue.write_buffer(&self.fixed.counters, 0, &[0; 4 * COUNTERS]);
        let (asked, names) = self.submit([n_rays, columns, groups], settings.average, &read);
        self.gpu.check()?;
        Ok(UnderWay { asked, names, read, n_rays, growth: self.growth })
    }

    /// The field's densities at points in the unit cube.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn densities(&self, points: &[[f32; 3]]) -> Result<Vec<f32>, Error> {
        use wgpu::BufferUsages as Usage;
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let gpu = &self.gpu;
        let quads: Vec<[f32; 4]> = points.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
        let given = gpu.upload("points", bytemuck::cast_slice(&quads))?;
        let bytes = 4 * points.len() as u64;
        let found = gpu.buffer("points", bytes, Usage::STORAGE | Usage::COPY_SRC)?;
        let read = gpu.buffer("points", bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let f = &self.fixed;
        let buffers = [(1, &f.weights), (2, &f.rounded), (4, &f.factors), (0, &f.frame)];
        let mut all = buffers.to_vec();
        all.extend([(40, &given), (41, &found)]);
        let group = self.pipelines.look.group(gpu, &all)?;
        let mut all = Sequence::new(gpu, None);
        let groups = (points.len() as u32).div_ceil(64).min(MOST_GROUPS);
        self.pipelines.look.run(&mut all, &group, [groups, 1, 1]);
        all.encoder().copy_buffer_to_buffer(&found, 0, &read, 0, bytes);
        let asked = all.submit(gpu);
        gpu.read(asked, &read, bytes, bytemuck::pod_collect_to_vec)
    }

    /// Uploads the cells, where they are others than before.
    fn show_cells(&mut self, settings: &Settings<'_>) {
        let occupancy = &settings.occupancy;
        let bits = [occupancy.coarse_bytes(), occupancy.fine_bytes()];
        if self.cells != bits {
            let cells = pack_cells(Some(occupancy));
            let bytes = bytemuck::cast_slice(&cells);
            self.gpu.queue().write_buffer(&self.fixed.occupancy, 0, bytes);
            self.cells = bits.map(<[u8]>::to_vec);
        }
    }

    fn make_room(&mut self, n_rays: u32, columns: u32) -> Result<(), Error> {
        let needed = Room::new(self.samples, n_rays, columns, self.growth);
        if self.memory.room.holds(&needed) && self.memory.room.growth == self.growth {
            return Ok(());
        }
        // Half as much again, because their number changes from step to step.
        let more = |n: u32| n.saturating_add(n / 2);
        let room = Room::new(self.samples, more(n_rays), more(columns), self.growth);
        let networks = (&self.pipelines, &self.networks);
        let memory = Memory::new(&self.gpu, networks, &self.fixed, self.per_sample, room)?;
        self.memory = memory;
        Ok(())
    }

    fn frame(&self, s: &Settings<'_>, [n_rays, columns]: [u32; 2]) -> [u32; FRAME_WORDS] {
        let Room { columns: apart, chunks, kept, .. } = self.memory.room;
        let networks = &s.networks;
        let slow = if s.slow_below > 0.0 { 1.0 / (s.slow_below * s.slow_below) } else { 0.0 };
        let numbers = [
            [s.min_transmittance, s.coarse_step_below, s.step, s.roulette],
            [s.tables.rate, s.tables.kept, s.tables.new, s.tables.epsilon],
            [slow, s.smooth_surfaces, 0.0, 0.0],
            [networks.muon.unwrap_or(0.0), networks.adam, networks.new[0], networks.new[1]],
        ];
        let flags = [s.blur_directions, s.between_views, networks.muon.is_some(), s.average];
        let flags = (0..).zip(flags).map(|(bit, is_set)| u32::from(is_set) << bit).sum();
        let chance = s.number.wrapping_mul(0x9e37_79b9).rotate_left(16);
        let whole = [
            [1, n_rays, columns, self.cameras],
            [apart, kept, chunks, kept],
            [s.seed, s.number, flags, chance],
        ];
        let mut words = [0; FRAME_WORDS];
        let bits = numbers.as_flattened().iter().map(|number| number.to_bits());
        let all = bits.chain(whole.as_flattened().iter().copied());
        words.iter_mut().zip(all).for_each(|(word, value)| *word = value);
        words
    }

    /// All kernels, one after another.
    fn submit(
        &self,
        [n_rays, columns, groups]: [u32; 3],
        average: bool,
        read: &wgpu::Buffer,
    ) -> (wgpu::SubmissionIndex, Vec<&'static str>) {
        let Self { gpu, pipelines: p, memory, fixed, .. } = self;
        let g = &memory.groups;
        let mut all = Sequence::new(gpu, self.watch.as_ref());
        let to = &mut all;
        let by_ray = [n_rays.div_ceil(64), 1, 1];
        let by_column = columns.div_ceil(64).min(MOST_GROUPS);
        let by_sample = memory.room.kept.div_ceil(64).min(MOST_GROUPS);
        let with_asked = [(n_rays + groups).div_ceil(64), 1, 1];
        let by_slots = |together: Together| n_rays.div_ceil(together.slots).min(MOST_GROUPS);
        let tracing = self.networks.rows.together.map_or(by_ray, |own| [by_slots(own), 1, 1]);
        p.trace.run(to, &g.trace, tracing);
        p.shade.run(to, &g.shade, with_asked);
        for (group, blocks) in &g.color.forward {
            p.dense_rays.run(to, group, [by_column, *blocks, 1]);
        }
        p.loss.run(to, &g.loss, with_asked);
        for (group, blocks) in &g.color.backward {
            p.dense_rays.run(to, group, [by_column, *blocks, 1]);
        }
        p.drop.run(to, &g.drop, by_ray);
        p.scan.run(to, &g.scan, [1; 3]);
        p.gather.run(to, &g.gather, by_ray);
        p.encode_again.run(to, &g.encode_again, [by_sample, 1, 1]);
        for (group, blocks) in g.density.forward.iter().chain(&g.density.backward) {
            p.dense_samples.run(to, group, [by_sample, *blocks, 1]);
        }
        for (layers, outer) in [(&g.density, &p.outer_samples), (&g.color, &p.outer_rays)] {
            for (parts, sum, product) in &layers.products {
                let [a, b] = product.tiles();
                outer.run(to, parts, [PARTS, a, b]);
                p.reduce.run(to, sum, [product.len().div_ceil(SUMS), 1, 1]);
            }
        }
        self.following.follow(p, to);
        let n_levels = self.tables.len() as u32;
        p.sum_units.run(to, &g.sum_units, [UNIT_PARTS, n_levels, 1]);
        p.find_units.run(to, &g.find_units, [1; 3]);
        let corners = (memory.room.kept * self.n_features).div_ceil(32).min(2 * MOST_GROUPS);
        p.scatter.run(to, &g.scatter, [corners, n_levels, 1]);
        self.follow(to, average);
        let (results, counters) = (16 * u64::from(n_rays), fixed.counters.size());
        let encoder = all.encoder();
        encoder.copy_buffer_to_buffer(&fixed.counters, 0, read, 0, counters);
        encoder.copy_buffer_to_buffer(&memory.results, 0, read, counters, results);
        let names = all.names.clone();
        (all.submit(gpu), names)
    }
}
