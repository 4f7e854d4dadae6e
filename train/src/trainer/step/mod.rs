//! One step: rays through the field, gradients back, new parameters.

mod back;
pub(crate) mod group;
mod march;
mod nerf;
mod paper;
mod shade;
mod worker;

use std::time::Instant;

use fearless_simd::{Level, dispatch};
use pocketnerf_core::AnyField;
use pocketnerf_core::march::Marcher;
use rayon::prelude::*;

use crate::probe::Probe;
use crate::random::Random;
use crate::stopwatch::{Laps, Stage};
use crate::trainer::occupancy::density_grid::OccupancyGrid;
use crate::trainer::{GROUPS, Trainer};
use group::{Group, GroupStats, Job, Worker};

/// Steps between two updates of the occupancy.
pub(crate) const OCCUPANCY_EVERY: u32 = 16;
/// The neighbours of occupied cells are looked at in one of so many steps.
const GROWN_EVERY: u32 = 8;
/// Steps between two looks at where the error is.
const ATTENTION_EVERY: u32 = 128;
/// Where less light than this passes, samples stand for several steps, as they do in
/// rendering.
const COARSE_STEP_BELOW: f32 = 0.3;
/// Rays of a step at most, where their number adapts itself.
pub(crate) const MOST_RAYS: usize = 1 << 17;
/// What a step found out.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepStats {
    /// Rays of the step.
    pub rays: usize,
    /// Samples at which the field was asked.
    pub samples: usize,
    /// Samples passed back.
    pub kept: usize,
    /// Mean squared error over all pixels and colours, estimated.
    pub mean_squared_error: f64,
    /// Mean opacity of all pixels, estimated.
    pub mean_opacity: f64,
}

/// How a step is to be taken: what the plan of a run decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// Factor on the learning rates.
    pub rate: f32,
    /// Part of a grid entry that is taken away where there is a gradient, times
    /// the learning rate.
    pub decay: f32,
    /// Factor on the distance between samples.
    pub step_scale: f32,
    /// Share of samples to pass back.
    pub kept: f32,
    /// Whether the occupancy still changes.
    pub update_occupancy: bool,
    /// Whether the parameters after the step count in their average.
    pub average: bool,
}

#[cfg(test)]
impl StepSettings {
    /// All samples at full rate, nothing else.
    pub(crate) const PLAIN: Self = Self {
        rate: 1.0,
        decay: 0.0,
        step_scale: 1.0,
        kept: 1.0,
        update_occupancy: false,
        average: false,
    };
}

impl Trainer {
    /// Takes one step.
    pub fn step(&mut self, settings: &StepSettings) -> StepStats {
        if settings.update_occupancy && self.step.is_multiple_of(OCCUPANCY_EVERY) {
            let begun = Instant::now();
            self.update_occupancy();
            if let Some(stopwatch) = &self.stopwatch {
                // Threads that wait for the others count too.
                let time = begun.elapsed() * rayon::current_num_threads() as u32;
                stopwatch.add(Stage::Occupancy, time, 1);
            }
        }
        self.backward.update(&self.parameters[self.layout.networks_start()..]);
        self.run_groups(settings);
        let stats = self.gather_stats();
        self.note_errors();
        self.plan_next(settings, &stats);
        self.step += 1;
        self.update_parameters(settings);
        if settings.average {
            self.accumulate();
        }
        stats
    }

    pub(crate) fn update_occupancy(&mut self) {
        let mut grid = std::mem::take(&mut self.grid);
        self.look_at_cells(&mut grid);
        grid.settle(self.sampling.step);
        self.grid = grid;
    }

    /// Looks at a share of a grid's cells.
    pub(crate) fn look_at_cells(&self, grid: &mut OccupancyGrid) {
        let Self { layout, config, parameters, rounded, level, limits, probes, seed, .. } = self;
        let field = match config.nerf_field() {
            Some(_) => layout.view(&config.field, parameters),
            None => layout.view_rounded(&config.field, rounded),
        };
        let field = field.expect("checked when training began");
        let new = || Probe::new(*limits);
        grid.look(*level, &field, *seed, probes, new);
    }

    /// Forward and backward of every group.
    fn run_groups(&mut self, settings: &StepSettings) {
        let mut sampling = self.sampling;
        sampling.step *= settings.step_scale;
        // Now and then the neighbours of what is occupied have to be empty: else what
        // they share entries with would fill them unseen.
        let neighbours = self.step % GROWN_EVERY == GROWN_EVERY - 1;
        let occupancy = if neighbours { self.grid.grown() } else { self.grid.view() };
        let job = Job {
            marcher: Marcher::from_parts(Some(occupancy), self.space, sampling, true),
            backward: &self.backward,
            step: sampling.step,
            coarse_step_below: COARSE_STEP_BELOW,
            roulette: if settings.kept < 1.0 { self.roulette } else { 0.0 },
            paper: self.config.paper,
            space: self.space,
            reach: [sampling.near, sampling.far],
            stopwatch: self.stopwatch.as_ref(),
        };
        // The paper's field learns as it is, others as they will be stored.
        let field = match self.config.nerf_field() {
            Some(_) => self.layout.view(&self.config.field, &self.parameters),
            None => self.layout.view_rounded(&self.config.field, &self.rounded),
        };
        let field = field.expect("checked when training began");
        let hierarchical = self.config.paper.map(|paper| paper.sampling);
        let cropped = self.config.paper.is_some_and(|paper| self.step < paper.crop_steps);
        let (seed, step) = (self.seed, u64::from(self.step));
        let (level, limits, n_rays) = (self.level, self.limits, self.n_rays);
        let (source, aim) = (&self.source, (&self.aim, &self.attention));
        self.groups.par_iter_mut().enumerate().with_max_len(1).for_each(|(g, group)| {
            let mut worker =
                self.workers.take(|| Worker::new(limits, &self.backward, hierarchical));
            let n = (g + 1) * n_rays / GROUPS - g * n_rays / GROUPS;
            let mut laps = Laps::begin(job.stopwatch);
            let random = Random::new(seed, [1, step, g as u64]);
            match hierarchical {
                None => group.draw(source, aim, n, random),
                Some(_) => group.draw_anywhere(source, n, cropped, random),
            }
            laps.end(Stage::Aim, n);
            match &field {
                AnyField::Nerf(field) => {
                    dispatch!(level, simd => group.run_nerf(simd, field, &job, &mut worker));
                }
                field => run_group(level, group, field, &job, &mut worker),
            }
            self.workers.put(worker);
        });
    }

    fn gather_stats(&self) -> StepStats {
        let mut total = GroupStats::default();
        for group in &self.groups {
            total.squared_error += group.stats.squared_error;
            total.opacity += group.stats.opacity;
            total.samples += group.stats.samples;
            total.kept += group.stats.kept;
        }
        if self.config.paper.is_some() {
            return StepStats {
                rays: self.n_rays,
                samples: total.samples,
                kept: total.kept,
                mean_squared_error: total.squared_error / (3 * self.n_rays) as f64,
                mean_opacity: total.opacity / self.n_rays as f64,
            };
        }
        let share = self.aim.share();
        let drawn_error = total.squared_error / (3 * self.n_rays) as f64;
        StepStats {
            rays: self.n_rays,
            samples: total.samples,
            kept: total.kept,
            mean_squared_error: share * drawn_error + self.targets.unseen_error,
            mean_opacity: share * total.opacity / self.n_rays as f64,
        }
    }

    /// Where the error is, and so where rays are to be drawn.
    fn note_errors(&mut self) {
        if self.config.paper.is_some() {
            return;
        }
        for (tile, error) in self.groups.iter().flat_map(Group::errors) {
            self.attention.note(tile, error);
        }
        if (self.step + 1).is_multiple_of(ATTENTION_EVERY) {
            self.attention.update();
        }
    }

    /// Chooses the next step's number of rays and roulette threshold from
    /// what this one met, so that steps cost about the same.
    fn plan_next(&mut self, settings: &StepSettings, stats: &StepStats) {
        let mean: f64 = self.groups.iter().map(|g| g.stats.gradient_size).sum::<f64>()
            / stats.samples.max(1) as f64;
        let share = stats.kept as f32 / stats.samples.max(1) as f32;
        if settings.kept < 1.0 {
            if self.roulette == 0.0 {
                self.roulette = mean as f32;
            } else {
                let correction = (share / settings.kept).clamp(0.8, 1.25);
                self.roulette *= correction;
            }
        }
        if self.config.batch_rays.is_none() {
            let per_ray = stats.samples as f64 / stats.rays as f64;
            let wanted = self.config.samples_per_step as f64 / per_ray.max(0.1);
            // Half of the way: one odd batch must not upset the next.
            let n = 0.5 * (self.n_rays as f64 + wanted);
            self.n_rays = (n as usize).clamp(256, MOST_RAYS);
        }
    }
}

pub(crate) fn run_group(
    level: Level,
    group: &mut Group,
    field: &AnyField<'_>,
    job: &Job<'_>,
    worker: &mut Worker,
) {
    match field {
        AnyField::HashGrid(field) => dispatch!(level, simd => group.run(simd, field, job, worker)),
        _ => unreachable!("kinds that this crate lays out"),
    }
}
