//! One step: rays through the field, gradients back, new parameters.

mod back;
mod between_views;
mod blurred_direction;
pub(crate) mod group;
mod hierarchical;
mod march;
pub(crate) mod poses;
mod shade;
pub(crate) mod slow_below;
mod surfaces;
pub(crate) mod worker;

use std::time::Instant;

use super::Trainer;
use super::backend::{StepInput, StepOutput};
use super::gains::GainStep;
use super::occupancy::density_grid::DensityGrid;
use crate::stopwatch::Stage;

/// Where less light than this passes, samples stand for several steps, as they do in
/// rendering.
pub(super) const COARSE_STEP_BELOW: f32 = 0.3;
/// Steps between two updates of the occupancy.
pub(crate) const OCCUPANCY_EVERY: u32 = 16;
/// The neighbours of occupied cells are sampled in one of so many steps.
const GROWN_EVERY: u32 = 8;
/// Steps between two updates of the pixel sampler.
const IMPORTANCE_EVERY: u32 = 128;
/// Rays of a step at most, where their number adapts itself.
pub(crate) const MOST_RAYS: usize = 1 << 17;

/// What a step found out.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepStats {
    /// Rays of the step; none where it found nothing out.
    pub rays: usize,
    /// Samples at which the field was evaluated.
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
    /// Share of the way to the mean of its neighbours that a grid entry goes where there is a
    /// gradient, times the learning rate.
    pub smoothing: f32,
    /// Factor on the distance between samples.
    pub step_scale: f32,
    /// Share of samples to pass back.
    pub kept: f32,
    /// Whether the occupancy still changes.
    pub update_occupancy: bool,
    /// Whether the parameters after the step count in their average.
    pub average: bool,
    /// Whether colours between the training views are held to what these see.
    pub between_views: bool,
    /// Width of what rays of a pixel go through, of few forward-facing photographs, pixels; 0: its
    /// centre alone.
    pub spread: f32,
    /// Share of the run that is done.
    pub progress: f32,
}

#[cfg(test)]
impl StepSettings {
    /// All samples at full rate, nothing else.
    pub(crate) const PLAIN: Self = Self {
        rate: 1.0,
        decay: 0.0,
        smoothing: 0.0,
        step_scale: 1.0,
        kept: 1.0,
        update_occupancy: false,
        average: false,
        between_views: false,
        spread: 0.0,
        progress: 0.0,
    };
}

impl Trainer {
    /// Takes one step. On a GPU, what it gives is what the step before found out.
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
        self.grow(settings.progress).expect("a shape that the kind itself gives");
        let output = self.backend_step(settings);
        self.correct_photographs();
        let stats = self.stats(&output);
        self.note_errors(&output);
        self.plan_next(settings, &output);
        self.step += 1;
        stats
    }

    /// Waits for steps that are under way, and gives what the last one found out.
    pub(crate) fn wait(&mut self) -> StepStats {
        let output = self.backend.wait();
        self.stats(&output)
    }

    fn backend_step(&mut self, settings: &StepSettings) -> StepOutput {
        let mut sampling = self.sampling;
        sampling.step *= settings.step_scale;
        // Now and then the neighbours of what is occupied have to be empty: else what
        // they share entries with would fill them unseen.
        let neighbours = self.step % GROWN_EVERY == GROWN_EVERY - 1;
        let occupancy = match (self.backend.skips_by_table(), neighbours) {
            (false, _) => self.grid.bare(neighbours),
            (true, true) => self.grid.grown(),
            (true, false) => self.grid.view(),
        };
        self.backend.step(&StepInput {
            source: &self.source,
            visibility: &self.visibility,
            sampler: &self.sampler,
            n_rays: self.n_rays,
            seed: self.seed,
            step: self.step,
            space: self.space,
            occupancy,
            sampling,
            coarse_step_below: self.coarse_step_below,
            hierarchical: self.config.hierarchical_training(),
            roulette: if settings.kept < 1.0 { self.roulette } else { 0.0 },
            table_rate: self.config.grid_rate * settings.rate,
            table_decay: settings.decay,
            table_smoothing: settings.smoothing,
            rate: self.config.network_rate * settings.rate,
            average: settings.average,
            between_views: settings.between_views && self.space.scene_box().is_some(),
            blur_directions: self.source.has_few_views() && self.space.scene_box().is_some(),
            smooth_surfaces: self.config.smooth_surfaces,
            spread: if self.spreads() { settings.spread } else { 0.0 },
            gains: GainStep::new(self.source.exposure().gains(), settings.progress),
            poses: self.poses.as_ref().map(|poses| poses.step(settings.progress)),
            stopwatch: self.stopwatch.as_ref(),
        })
    }

    /// Whether photographs of few, forward-facing cameras would be learnt by heart: they differ by
    /// fractions of a pixel in where things are.
    fn spreads(&self) -> bool {
        self.config.ndc.is_some() && self.source.has_few_views()
    }

    pub(crate) fn update_occupancy(&mut self) {
        let mut grid = std::mem::take(&mut self.grid);
        self.look_at_cells(&mut grid);
        grid.settle(self.sampling.step, self.clearing.factor);
        self.grid = grid;
    }

    /// Looks at a share of a grid's cells.
    pub(crate) fn look_at_cells(&self, grid: &mut DensityGrid) {
        self.backend.densities(grid, self.seed);
    }

    fn stats(&self, output: &StepOutput) -> StepStats {
        // Rays that are drawn anywhere stand for all pixels, others for those of their tiles.
        let (share, unseen_error) = match self.config.hierarchical_training() {
            Some(_) => (1.0, 0.0),
            None => (self.visibility.share(), self.targets.unseen_error),
        };
        if output.rays == 0 {
            return StepStats::default();
        }
        let share = share / self.source.photographed_share();
        let drawn_error = output.squared_error / (3 * output.rays) as f64;
        StepStats {
            rays: output.rays,
            samples: output.samples,
            kept: output.kept,
            mean_squared_error: share * drawn_error + unseen_error,
            mean_opacity: share * output.opacity / output.rays as f64,
        }
    }

    /// Where the error is, and so where rays are to be drawn.
    fn note_errors(&mut self, output: &StepOutput) {
        for (tile, error) in &output.errors {
            self.sampler.note(*tile, *error);
        }
        if !output.errors.is_empty() && (self.step + 1).is_multiple_of(IMPORTANCE_EVERY) {
            self.sampler.update();
        }
    }

    /// Chooses the next step's number of rays and roulette threshold from
    /// what this one met, so that steps cost about the same.
    fn plan_next(&mut self, settings: &StepSettings, output: &StepOutput) {
        if output.rays == 0 {
            return;
        }
        let mean = output.gradient_size / output.samples.max(1) as f64;
        let share = output.kept as f32 / output.samples.max(1) as f32;
        if settings.kept < 1.0 {
            // Of what the step that found it out had: others may be under way.
            self.roulette = match output.roulette {
                0.0 => mean as f32,
                before => before * (share / settings.kept).clamp(0.8, 1.25),
            };
        }
        if self.config.batch_rays.is_none() {
            let per_ray = output.samples as f64 / output.rays as f64;
            let wanted = self.config.samples_per_step as f64 / per_ray.max(0.1);
            // Half of the way: one odd batch must not upset the next.
            let n = 0.5 * (output.rays as f64 + wanted);
            self.n_rays = (n as usize).clamp(256, MOST_RAYS);
        }
    }
}
