//! Rays of a GPU's steps: drawn in blocks, those of the next step while the GPU computes this one.

use std::ops::Range;

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
    rays: Rays,
    ahead: Rays,
    /// How many blocks of those ahead are drawn, and for which step.
    is_ahead: Option<(usize, Key)>,
    /// Where blocks are drawn.
    groups: Vec<Group>,
    /// Tests compare steps with those of the CPU.
    #[cfg(test)]
    pub(super) like_the_cpu: bool,
}

/// The tile that a ray was drawn from, and what it weighs.
pub(super) type Origin = (u32, f32);

/// Rays, as a GPU has them, and where they come from.
#[derive(Debug, Default)]
struct Rays {
    numbers: Vec<PixelNumbers>,
    origins: Vec<Origin>,
}

impl Drawing {
    /// Draws the rays of a step.
    pub(super) fn draw(&mut self, input: &StepInput<'_>) -> (&[PixelNumbers], &[Origin]) {
        let n = input.n_rays;
        #[cfg(test)]
        if self.like_the_cpu {
            self.draw_like_the_cpu(input);
            return (&self.rays.numbers[..n], &self.rays.origins[..n]);
        }
        let mut done = 0;
        if let Some((n, _)) = self.is_ahead.take().filter(|(_, drawn)| *drawn == key(input)) {
            std::mem::swap(&mut self.rays, &mut self.ahead);
            done = n;
        }
        self.rays.draw(&mut self.groups, done..n.div_ceil(BLOCK).max(done), input);
        (&self.rays.numbers[..n], &self.rays.origins[..n])
    }

    /// Draws rays for the step after this one.
    pub(super) fn draw_ahead(&mut self, input: &StepInput<'_>) {
        let next = StepInput { step: input.step + 1, ..*input };
        let n = (input.n_rays + input.n_rays / MORE).div_ceil(BLOCK);
        self.ahead.draw(&mut self.groups, 0..n, &next);
        self.is_ahead = Some((n, key(&next)));
    }

    #[cfg(test)]
    fn draw_like_the_cpu(&mut self, input: &StepInput<'_>) {
        use crate::trainer::GROUPS;

        self.rays = Rays::default();
        for g in 0..GROUPS {
            let mut group = Group::default();
            let n = (g + 1) * input.n_rays / GROUPS - g * input.n_rays / GROUPS;
            group.draw(input, n, Random::new(input.seed, [1, u64::from(input.step), g as u64]));
            self.rays.numbers.extend(all_numbers(&group));
            self.rays.origins.extend(all_origins(&group, input));
        }
    }
}

impl Rays {
    /// Draws some of the blocks of a step.
    fn draw(&mut self, groups: &mut Vec<Group>, which: Range<usize>, input: &StepInput<'_>) {
        let n = which.len().max(groups.len());
        groups.resize_with(n, Group::default);
        let end = which.end * BLOCK;
        if self.numbers.len() < end {
            self.numbers.resize(end, PixelNumbers::default());
            self.origins.resize(end, Origin::default());
        }
        let places = which.start * BLOCK..end;
        let rows = self.numbers[places.clone()].par_chunks_mut(BLOCK);
        let rows = rows.zip(self.origins[places].par_chunks_mut(BLOCK));
        rows.zip(groups).zip(which).for_each(|(((to, origins), group), number)| {
            let mut laps = Laps::begin(input.stopwatch);
            let random = Random::new(input.seed, [1, u64::from(input.step), number as u64]);
            group.draw(input, BLOCK, random);
            to.iter_mut().zip(all_numbers(group)).for_each(|(to, numbers)| *to = numbers);
            origins.iter_mut().zip(all_origins(group, input)).for_each(|(to, own)| *to = own);
            laps.end(Stage::Pixels, BLOCK);
        });
    }
}

/// Of the rays of a group; those of photographs alone weigh something in what the step reports.
/// Rays that are drawn anywhere have no pixels noted.
fn all_origins<'g>(
    group: &'g Group,
    input: &StepInput<'g>,
) -> impl Iterator<Item = Origin> + use<'g> {
    let source = input.source;
    let counts =
        move |i: usize| group.pixels.get(i).is_none_or(|pixel| source.is_photograph(pixel.view));
    let rays = group.rays.iter().enumerate();
    rays.map(move |(i, ray)| (ray.tile, if counts(i) { ray.weight } else { 0.0 }))
}

fn key(input: &StepInput<'_>) -> Key {
    (input.seed, input.step, input.sampler.changes())
}

/// Of the rays of a group.
fn all_numbers(group: &Group) -> impl Iterator<Item = PixelNumbers> + '_ {
    let begins_row = |i: u32| group.rows.binary_search(&i).is_ok();
    (0..).zip(&group.rays).map(move |(i, ray)| numbers(ray, begins_row(i)))
}

fn numbers(ray: &TrainingRay, begins_row: bool) -> PixelNumbers {
    Pixel {
        ray: ray.ray,
        phase: ray.phase,
        weight: ray.weight,
        begins_row,
        background: ray.background,
        background_variance: ray.background_variance,
        target: ray.target,
        alpha: ray.alpha,
    }
    .numbers()
}
