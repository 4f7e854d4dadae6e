//! Rays of a GPU's steps: drawn in blocks, those of the next step while the GPU computes this one.

use pocketnerf_gpu::training::{Pixel, PixelNumbers};
use rayon::prelude::*;

use super::StepInput;
use crate::random::Random;
use crate::stopwatch::{Laps, Stage};
use crate::trainer::pixels::rays::TrainingRay;
use crate::trainer::step::group::Group;

/// Rays of a block, which has random numbers of its own: how many blocks are drawn changes none.
const BLOCK: usize = 256;
/// More rays are drawn ahead than this step has, by one in so many: their number changes.
const MORE: usize = 16;

/// What the rays of a step depend on beside their number: seed, step, and which tiles are drawn.
type Key = (u64, u32, u32);

/// The rays of a step, and of the next one.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    blocks: Vec<Group>,
    n_rays: usize,
    ahead: Vec<Group>,
    /// Of how many blocks ahead, and for which step.
    is_ahead: Option<(usize, Key)>,
    /// Tests compare steps with those of the CPU.
    #[cfg(test)]
    pub(super) like_the_cpu: bool,
}

impl Drawing {
    /// Draws the rays of a step.
    pub(super) fn draw(&mut self, input: &StepInput<'_>) -> Vec<PixelNumbers> {
        self.n_rays = input.n_rays;
        #[cfg(test)]
        if self.like_the_cpu {
            self.draw_like_the_cpu(input);
            return self.rays().map(numbers).collect();
        }
        let mut done = 0;
        if let Some((n, _)) = self.is_ahead.take().filter(|(_, drawn)| *drawn == key(input)) {
            std::mem::swap(&mut self.blocks, &mut self.ahead);
            done = n;
        }
        let n = input.n_rays.div_ceil(BLOCK);
        draw(&mut self.blocks, done..n.max(done), input);
        let rows = self.blocks.par_iter().take(n);
        let mut all: Vec<_> = rows.flat_map_iter(|block| block.rays.iter().map(numbers)).collect();
        all.truncate(input.n_rays);
        all
    }

    /// Draws rays for the step after this one.
    pub(super) fn draw_ahead(&mut self, input: &StepInput<'_>) {
        let next = StepInput { step: input.step + 1, ..*input };
        let n = (input.n_rays + input.n_rays / MORE).div_ceil(BLOCK);
        draw(&mut self.ahead, 0..n, &next);
        self.is_ahead = Some((n, key(&next)));
    }

    /// The rays of this step.
    pub(super) fn rays(&self) -> impl Iterator<Item = &TrainingRay> {
        self.blocks.iter().flat_map(|block| &block.rays).take(self.n_rays)
    }

    #[cfg(test)]
    fn draw_like_the_cpu(&mut self, input: &StepInput<'_>) {
        use crate::trainer::GROUPS;

        self.blocks.resize_with(GROUPS, Group::default);
        for (g, group) in self.blocks.iter_mut().enumerate() {
            let n = (g + 1) * input.n_rays / GROUPS - g * input.n_rays / GROUPS;
            group.draw(input, n, Random::new(input.seed, [1, u64::from(input.step), g as u64]));
        }
    }
}

fn key(input: &StepInput<'_>) -> Key {
    (input.seed, input.step, input.sampler.changes())
}

/// Draws some of the blocks of a step.
fn draw(blocks: &mut Vec<Group>, which: std::ops::Range<usize>, input: &StepInput<'_>) {
    if blocks.len() < which.end {
        blocks.resize_with(which.end, Group::default);
    }
    blocks[which.clone()].par_iter_mut().zip(which).for_each(|(block, number)| {
        let mut laps = Laps::begin(input.stopwatch);
        let random = Random::new(input.seed, [1, u64::from(input.step), number as u64]);
        block.draw(input, BLOCK, random);
        laps.end(Stage::Pixels, BLOCK);
    });
}

fn numbers(ray: &TrainingRay) -> PixelNumbers {
    Pixel {
        ray: ray.ray,
        phase: ray.phase,
        weight: ray.weight,
        background: ray.background,
        background_variance: ray.background_variance,
        target: ray.target,
        alpha: ray.alpha,
    }
    .numbers()
}
