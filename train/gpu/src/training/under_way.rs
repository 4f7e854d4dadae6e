//! Steps that a GPU has been asked for, and what becomes of them.

use super::Learner;
use super::fixed::COUNTERS;
use super::memory::Room;
use super::step::{RayResult, StepResult};
use crate::render::Error;

/// Numbers of counters: `step.wgsl`.
const NEXT_CHUNK: usize = 0;
const TOO_MANY: usize = 1;
const KEPT: usize = 2;
const NOT_FINITE: usize = 3;
/// Samples of a step are at most so many times as many as were expected.
const MOST_GROWTH: u32 = 64;
/// Steps after which memory that none of them needed is given back.
const LOOKED_BACK: u32 = 64;

/// How much memory the last steps needed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Used {
    steps: u32,
    /// How many times as much as usual.
    most: u32,
}

/// A step that a GPU has been asked for.
#[derive(Debug)]
pub struct UnderWay {
    pub(super) asked: wgpu::SubmissionIndex,
    /// Its kernels, where their times are asked for.
    pub(super) names: Vec<&'static str>,
    /// Its results, where the CPU can read them.
    pub(super) read: wgpu::Buffer,
    pub(super) n_rays: u32,
    /// How many times as many samples as usual it had room for.
    pub(super) growth: u32,
}

/// Bytes of counters and of what becomes of so many rays.
pub(super) const fn counted_bytes(n_rays: u32) -> u64 {
    4 * COUNTERS as u64 + 16 * n_rays as u64
}

impl Learner {
    /// Waits for a step, and says what became of it.
    ///
    /// # Errors
    /// [`Error::Device`], or where samples are too many for any memory.
    pub fn result(&mut self, step: UnderWay) -> Result<StepResult, Error> {
        let UnderWay { asked, names, read, n_rays, growth } = step;
        let usual = Room::new(self.samples, n_rays, n_rays, 1);
        let times = match &self.watch {
            Some(watch) if !names.is_empty() => watch.read(&self.gpu, &names, asked.clone())?,
            _ => Vec::new(),
        };
        let bytes = counted_bytes(n_rays);
        let (rays, counters) = self.gpu.read(asked, &read, bytes, |bytes| {
            let (counters, rays) = bytes.split_at(4 * COUNTERS);
            let mut counted = [0u32; COUNTERS];
            bytemuck::cast_slice_mut(&mut counted).copy_from_slice(counters);
            (rays.as_chunks().0.iter().map(RayResult::of).collect(), counted)
        })?;
        self.free.push(read);
        let is_finite = counters[NOT_FINITE] == 0;
        if counters[TOO_MANY] == 0 {
            self.note_use(usual.growth(counters[NEXT_CHUNK], counters[KEPT]));
            return Ok(StepResult { rays, is_finite, times });
        }
        // Nothing was learnt. Others that were under way may have had too little room, too.
        if growth == self.growth {
            self.growth *= 2;
            self.used = Used::default();
        }
        if self.growth > MOST_GROWTH {
            return Err(pocketnerf_core::Error::TooManySamples { allowed: 0 }.into());
        }
        Ok(StepResult { rays: Vec::new(), is_finite, times })
    }

    /// Gives memory back that many steps have not needed: rows that are far apart take longer.
    fn note_use(&mut self, growth: u32) {
        self.used.most = self.used.most.max(growth);
        self.used.steps += 1;
        if self.used.steps == LOOKED_BACK {
            // Half as much again may be needed next.
            let enough = (self.used.most * 3).div_ceil(2).next_power_of_two();
            self.growth = self.growth.min(enough);
            self.used = Used::default();
        }
    }

    /// A buffer for results that no step has.
    pub(super) fn place_to_read(&mut self, n_rays: u32) -> Result<wgpu::Buffer, Error> {
        use wgpu::BufferUsages as Usage;
        let bytes = counted_bytes(n_rays);
        self.free.retain(|buffer| buffer.size() >= bytes);
        if let Some(buffer) = self.free.pop() {
            return Ok(buffer);
        }
        let bytes = counted_bytes(self.memory.room.rays.max(n_rays));
        self.gpu.buffer("results", bytes, Usage::MAP_READ | Usage::COPY_DST)
    }
}
