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

impl Used {
    /// Notes how many times as much memory as usual a step needed. After enough of them, it says how
    /// many times as much will do: half as much again may be needed next.
    fn note(&mut self, growth: u32) -> Option<u32> {
        self.most = self.most.max(growth);
        self.steps += 1;
        if self.steps < LOOKED_BACK {
            return None;
        }
        let most = std::mem::take(self).most;
        Some((3 * most).div_ceil(2).next_power_of_two())
    }
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
const fn counted_bytes(n_rays: u32) -> u64 {
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
            if let Some(enough) = self.used.note(usual.growth(counters[NEXT_CHUNK], counters[KEPT]))
            {
                self.growth = self.growth.min(enough);
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_no_step_needed_is_given_back() {
        let mut used = Used::default();
        let mut steps =
            |growth: u32| (0..LOOKED_BACK).map(|_| used.note(growth)).collect::<Vec<_>>();
        let mut expected = vec![None; LOOKED_BACK as usize];
        // Half as much again as the most that is needed, in powers of two.
        for (growth, enough) in [(1, 2), (2, 4), (3, 8), (5, 8), (1, 2)] {
            expected[LOOKED_BACK as usize - 1] = Some(enough);
            assert_eq!(steps(growth), expected, "{growth}");
        }
    }

    #[test]
    fn room_by_hand() {
        // Two chunks of sixteen for as many samples, and one a ray; five of eight samples are kept.
        let usual = Room::new(1024, 32, 40, 1);
        assert_eq!((usual.chunks, usual.kept), (2 * 64 + 32, 640));
        assert_eq!(
            [(160, 640), (161, 640), (1, 641), (481, 1)].map(|(c, k)| usual.growth(c, k)),
            [1, 2, 2, 4]
        );
        let larger = Room::new(1024, 32, 40, 4);
        assert!(larger.holds(&usual) && !usual.holds(&larger));
    }
}
