//! All that is learnt: how tables follow their gradients, in and out.

use std::sync::PoisonError;

use super::Learner;
use super::fixed::Fixed;
use super::following::LearntNumbers;
use super::learner::MOST_GROUPS;
use super::pipelines::Pipelines;
use super::sequence::Sequence;
use super::step::Learnt;
use crate::render::{Error, Gpu};

/// Values that are left alone only together: `tables.wgsl`.
const BLOCK: u32 = 16;

/// What the kernels of tables bind.
#[derive(Debug)]
pub(super) struct TableGroups {
    adam: wgpu::BindGroup,
    hold_all: wgpu::BindGroup,
    round_all: wgpu::BindGroup,
}

impl TableGroups {
    pub(super) fn new(gpu: &Gpu, p: &Pipelines, f: &Fixed) -> Result<Self, Error> {
        let adam = [
            (0, &f.frame),
            (9, &f.counters),
            (30, &f.table_of),
            (31, &f.units),
            (32, &f.entry_gradients),
            (33, &f.parameters),
            (34, &f.squares),
            (35, &f.largest),
        ];
        let hold_all = [(35, &f.largest), (36, &f.scales), (37, &f.factors)];
        let round_all = [(30, &f.table_of), (33, &f.parameters), (36, &f.scales), (38, &f.rounded)];
        Ok(Self {
            adam: p.adam.group(gpu, &adam)?,
            hold_all: p.hold_all.group(gpu, &hold_all)?,
            round_all: p.round_all.group(gpu, &round_all)?,
        })
    }
}

/// Sums of entries over the steps that count in the average, and what adds to them.
#[derive(Debug)]
pub(super) struct Sums {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Learner {
    /// New tables from their gradients, and what is rounded of them.
    pub(super) fn follow(&self, to: &mut Sequence<'_>, average: bool) {
        let (p, g) = (&self.pipelines, &self.groups);
        let blocks = self.most_values().div_ceil(64 * BLOCK);
        p.adam.run(to, &g.adam, [blocks, self.tables.len() as u32, 1]);
        self.round(to);
        if let (true, Some(sums)) = (average, &self.sums) {
            p.accumulate.run(to, &sums.group, [MOST_GROUPS, 1, 1]);
        }
    }

    /// What fields read of the tables.
    fn round(&self, to: &mut Sequence<'_>) {
        let (p, g) = (&self.pipelines, &self.groups);
        p.hold_all.run(to, &g.hold_all, [1; 3]);
        let words = self.most_values().div_ceil(64 * 4);
        p.round_all.run(to, &g.round_all, [words, self.tables.len() as u32, 1]);
    }

    /// Values of the largest table.
    fn most_values(&self) -> u32 {
        self.tables.iter().copied().max().unwrap_or(0)
    }

    /// Takes over what is learnt, all at once.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn set_learnt(&mut self, learnt: &Learnt) -> Result<(), Error> {
        let (f, queue) = (&self.fixed, self.gpu.queue());
        let n = self.n_values();
        let scales: &[[i32; 2]] = &learnt.scales;
        queue.write_buffer(&f.parameters, 0, bytemuck::cast_slice(&learnt.parameters[..n]));
        queue.write_buffer(&f.squares, 0, bytemuck::cast_slice(&learnt.square[..n]));
        queue.write_buffer(&f.scales, 0, bytemuck::cast_slice(scales));
        queue.write_buffer(&f.largest, 0, &vec![0; f.largest.size() as usize]);
        let sums = learnt.sum.get(n..).unwrap_or_default();
        let networks: Vec<LearntNumbers> = (0..learnt.mean.len())
            .map(|i| {
                let sum = sums.get(i).copied().unwrap_or(0.0);
                [learnt.parameters[n + i], learnt.mean[i], learnt.square[n + i], sum]
            })
            .collect();
        queue.write_buffer(&self.following.learnt, 0, bytemuck::cast_slice(&networks));
        let mut all = Sequence::new(&self.gpu, None);
        all.encoder().clear_buffer(&f.entry_gradients, 0, None);
        self.round(&mut all);
        self.following.lay_out(&self.pipelines, &mut all);
        all.submit(&self.gpu);
        self.sums = None;
        if !learnt.sum.is_empty() {
            let sums = self.no_sums()?;
            let bytes = bytemuck::cast_slice(&learnt.sum[..n]);
            self.gpu.queue().write_buffer(&sums.buffer, 0, bytes);
            self.sums = Some(sums);
        }
        self.gpu.check()
    }

    /// Values of all tables.
    fn n_values(&self) -> usize {
        self.tables.iter().sum::<u32>() as usize
    }

    /// Rounds each table to multiples of so many units from now on.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn set_scales(&mut self, scales: &[[i32; 2]]) -> Result<(), Error> {
        self.gpu.queue().write_buffer(&self.fixed.scales, 0, bytemuck::cast_slice(scales));
        let mut all = Sequence::new(&self.gpu, None);
        self.round(&mut all);
        all.submit(&self.gpu);
        self.gpu.check()
    }

    /// What is learnt after the last step that was begun.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn learnt(&self) -> Result<Learnt, Error> {
        let (f, networks) = (&self.fixed, &self.following.learnt);
        let sums = self.sums.as_ref().map(|sums| &sums.buffer);
        let parts = [&f.scales, networks, &f.parameters, &f.squares].into_iter().chain(sums);
        self.download(&parts.collect::<Vec<_>>(), |parts| {
            let [scales, networks, parameters, squares, sums @ ..] = parts else {
                return Learnt::default();
            };
            let networks: Vec<LearntNumbers> = bytemuck::pod_collect_to_vec(networks);
            let with = |tables: &[u8], number: usize| {
                let own = networks.iter().map(|numbers| numbers[number]);
                let tables: &[f32] = bytemuck::cast_slice(tables);
                tables.iter().copied().chain(own).collect()
            };
            Learnt {
                parameters: with(parameters, 0),
                mean: networks.iter().map(|[_, mean, ..]| *mean).collect(),
                square: with(squares, 2),
                sum: sums.first().map_or(Vec::new(), |sums| with(sums, 3)),
                scales: bytemuck::pod_collect_to_vec(scales),
            }
        })
    }

    /// The parameters alone, which takes a third of the time.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn parameters(&self) -> Result<Vec<f32>, Error> {
        let parts = [&self.fixed.parameters, &self.following.learnt];
        self.download(&parts, |parts| {
            let [tables, networks] = parts else { return Vec::new() };
            let (networks, _) = networks.as_chunks::<{ size_of::<LearntNumbers>() }>();
            let own = networks.iter().map(|numbers| {
                let numbers: LearntNumbers = bytemuck::cast(*numbers);
                numbers[0]
            });
            let tables: &[f32] = bytemuck::cast_slice(tables);
            tables.iter().copied().chain(own).collect()
        })
    }

    /// Sums that are all 0.
    pub(super) fn no_sums(&self) -> Result<Sums, Error> {
        use wgpu::BufferUsages as Usage;
        let (usage, parameters) =
            (Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST, &self.fixed.parameters);
        let buffer = self.gpu.buffer("sums of entries", parameters.size(), usage)?;
        let buffers = [(33, parameters), (39, &buffer)];
        let group = self.pipelines.accumulate.group(&self.gpu, &buffers)?;
        Ok(Sums { buffer, group })
    }

    /// What is in a few buffers, all at once.
    fn download<T>(
        &self,
        parts: &[&wgpu::Buffer],
        take: impl FnOnce(&[&[u8]]) -> T,
    ) -> Result<T, Error> {
        use wgpu::BufferUsages as Usage;
        let bytes = parts.iter().map(|part| part.size()).sum();
        // It is large, and it takes a driver long to make one.
        let place = self.downloads.lock().unwrap_or_else(PoisonError::into_inner).take();
        let read = match place.filter(|place| place.size() >= bytes) {
            Some(place) => place,
            None => self.gpu.buffer("tables", bytes, Usage::MAP_READ | Usage::COPY_DST)?,
        };
        let mut all = Sequence::new(&self.gpu, None);
        let mut to = 0;
        for part in parts {
            all.encoder().copy_buffer_to_buffer(part, 0, &read, to, part.size());
            to += part.size();
        }
        let asked = all.submit(&self.gpu);
        let taken = self.gpu.read(asked, &read, bytes, |mut bytes| {
            let part = |part: &&wgpu::Buffer| bytes.split_off(..part.size() as usize);
            let parts: Vec<&[u8]> = parts.iter().filter_map(part).collect();
            take(&parts)
        })?;
        *self.downloads.lock().unwrap_or_else(PoisonError::into_inner) = Some(read);
        Ok(taken)
    }
}
