//! The training loop: rays → march → shade → back → scatter → Adam.

mod aim;
mod cells;
pub mod checkpoint;
mod config;
#[cfg(test)]
mod gradient_tests;
mod group;
mod guard;
mod hull;
mod occupancy_grid;
mod optimizer;
mod pool;
mod rays;
mod run;
mod scene_box;
mod schedule;
mod scout;
mod update;

use std::time::Instant;

use fearless_simd::{Level, dispatch};
use pocketnerf_core::field::Field;
use pocketnerf_core::sampler::Marcher;
use pocketnerf_core::scratch::Limits;
use pocketnerf_core::store::{F16, Store};
use pocketnerf_core::{AnyField, ColorSpace, Display, Error, Model, Sampling, SimdLevel, Space};
use rayon::prelude::*;

pub use cells::{dilated, pack};
pub use checkpoint::{Checkpoint, CheckpointError};
pub use config::TrainConfig;
pub use guard::{Diverged, MAX_RESTARTS, Trouble};
pub use hull::Hull;
pub use occupancy_grid::OccupancyGrid;
pub use optimizer::{Adam, Slices};
pub use rays::{Backdrop, RaySource, Targets, TrainingRay};
pub use run::{Progress, Run, Summary, run};
pub use scene_box::find_box;
pub use schedule::{Length, Plan};

use crate::aligned::Aligned;
use crate::dataset::Dataset;
use crate::field::half::round_all;
use crate::field::{Backward, EncodingConfig, Layout, initialize};
use crate::random::Random;
use crate::stopwatch::{Laps, Stage, Stopwatch};
use aim::Aim;
use group::{Group, GroupStats, Job, MIN_TRANSMITTANCE, Worker};
use pool::Pool;

/// Shares that a step is cut into, at any number of threads.
pub(crate) const GROUPS: usize = 16;
/// Steps between two updates of the occupancy.
const OCCUPANCY_EVERY: u32 = 16;
/// The neighbours of occupied cells are looked at in one of so many steps.
const GROWN_EVERY: u32 = 8;
/// Rays of the first step, where their number adapts itself.
const FIRST_RAYS: usize = 1024;
/// Rays of a step at most, where their number adapts itself.
const MOST_RAYS: usize = 1 << 17;
/// Rays of a step at most, where the user sets their number.
pub const MAX_BATCH_RAYS: usize = 1 << 20;

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

/// A field in training.
#[derive(Debug)]
pub struct Trainer {
    config: TrainConfig,
    level: Level,
    source: RaySource,
    aim: Aim,
    targets: Targets,
    space: Space,
    sampling: Sampling,
    layout: Layout,
    parameters: Aligned<f32>,
    /// Gradient of the networks.
    gradient: Vec<f32>,
    /// Gradient buffers of grid levels, as many as there are threads: a level's
    /// is full only between its scatter and its update, and stays in the cache.
    level_gradients: Pool<Aligned<f32>>,
    /// Workers, as many as there are threads.
    workers: Pool<Worker>,
    mean: Vec<f32>,
    square: Aligned<f32>,
    /// The parameters in half precision: what the forward pass reads.
    half: Aligned<u16>,
    /// Sum of the parameters after `averaged` steps; empty before the first.
    sum: Vec<f32>,
    /// Steps whose parameters are in `sum`.
    averaged: u32,
    adam: Adam,
    backward: Backward,
    groups: Vec<Group>,
    limits: Limits,
    grid: OccupancyGrid,
    step: u32,
    n_rays: usize,
    /// Gradient magnitude below which the roulette plays.
    roulette: f32,
    /// How often training has begun anew.
    restarts: u32,
    /// Where this attempt's random numbers begin.
    seed: u64,
    /// Where the time of the steps is written down.
    stopwatch: Option<Stopwatch>,
}

impl Trainer {
    /// Prepares a run on `dataset`.
    ///
    /// # Errors
    /// When the configuration does not make a valid field, or the SIMD level is
    /// not there.
    pub fn new(dataset: Dataset, mut config: TrainConfig, simd: SimdLevel) -> Result<Self, Error> {
        let level = simd.token()?;
        if let EncodingConfig::HashGrid(grid) = &config.field.encoding {
            grid.validate()?;
        }
        let has_alpha = dataset.has_alpha;
        let backdrop = match (config.backdrop, has_alpha) {
            (Some(color), _) => Backdrop::Color(color),
            (None, true) => Backdrop::Random,
            (None, false) => Backdrop::Color(config.opaque_backdrop),
        };
        let mut source = RaySource::new(dataset.views, backdrop);
        let hull = has_alpha.then(|| Hull::new(source.cameras(), source.images()));
        let mut space = match config.aabb {
            Some([min, max]) => Space::Box { min, max },
            None => find_box(source.cameras(), hull.as_ref()),
        };
        if let (None, Some(hull)) = (config.aabb, &hull) {
            (space, source) = scout::tighten(space, source, hull, &config, level)?;
        }
        if let Space::Box { min, max } = space {
            // A checkpoint holds it: going on does not look for it again.
            config.aabb = Some([min, max]);
        }
        Self::in_space(source, hull.as_ref(), space, config, level)
    }

    /// Prepares a run in this space.
    fn in_space(
        source: RaySource,
        hull: Option<&Hull>,
        space: Space,
        mut config: TrainConfig,
        level: Level,
    ) -> Result<Self, Error> {
        space.validate()?;
        let scale = space.unit_map().scale;
        let step = 1.0 / (scale * config.samples_per_side);
        let far = config.far.unwrap_or(config.near + 64.0 / scale);
        let sampling =
            Sampling { step, near: config.near, far, min_transmittance: MIN_TRANSMITTANCE };
        sampling.validate()?;
        // Density is learnt per unit length of the cube, whatever its size.
        config.field.log_density_bias = scale.ln();
        let layout = Layout::new(&config.field);
        let parameters = Aligned::new(layout.len());
        let limits = layout.view(&config.field, &parameters)?.limits();
        let resolution = config.occupancy_resolution;
        let candidates = match hull {
            Some(hull) => hull.cells(&space, resolution),
            None => all_cells(&space, resolution),
        };
        let aim = Aim::new(source.cameras(), &space, resolution, &candidates);
        let backward = Backward::new(&config.field, &layout);
        let n_network = layout.len() - layout.networks_start();
        let group = || Group::new(n_network);
        let mut trainer = Self {
            level,
            targets: source.targets(&aim),
            source,
            aim,
            space,
            sampling,
            gradient: vec![0.0; n_network],
            level_gradients: Pool::default(),
            workers: Pool::default(),
            mean: vec![0.0; n_network],
            square: Aligned::new(layout.len()),
            half: Aligned::new(layout.len()),
            sum: Vec::new(),
            averaged: 0,
            adam: Adam::default(),
            backward,
            groups: (0..GROUPS).map(|_| group()).collect(),
            limits,
            grid: OccupancyGrid::new(resolution, candidates),
            step: 0,
            n_rays: FIRST_RAYS,
            roulette: 0.0,
            restarts: 0,
            seed: config.seed,
            stopwatch: None,
            parameters,
            layout,
            config,
        };
        trainer.begin(0);
        Ok(trainer)
    }

    /// The model as it stands.
    ///
    /// # Panics
    /// Never: the parts were checked when training began.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        let field = self.layout.view(&self.config.field, &self.parameters);
        Model {
            field: field.expect("checked when training began"),
            space: self.space,
            occupancy: Some(self.grid.view()),
            sampling: self.sampling,
            display: Display { background: [1.0; 3], color_space: ColorSpace::Srgb },
        }
    }

    /// The run's settings.
    #[must_use]
    pub const fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// Steps taken so far.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        self.step
    }

    /// How often training has begun anew.
    #[must_use]
    pub const fn restarts(&self) -> u32 {
        self.restarts
    }

    /// The occupancy as it stands.
    #[must_use]
    pub const fn occupancy(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// From now on the time of each stage is written down.
    pub(crate) fn watch(&mut self) {
        self.stopwatch = Some(Stopwatch::default());
    }

    /// What has been written down since then.
    pub(crate) fn stopwatch(&self) -> Option<&Stopwatch> {
        self.stopwatch.as_ref()
    }

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
        self.plan_next(settings, &stats);
        self.step += 1;
        self.update_parameters(settings);
        if settings.average {
            self.accumulate();
        }
        stats
    }

    /// Begins the `restarts`-th attempt after the first: each has random numbers
    /// of its own.
    fn begin(&mut self, restarts: u32) {
        self.restarts = restarts;
        self.seed = guard::seed(self.config.seed, restarts);
        let seed = self.seed;
        self.set_parameters(|layout, parameters| initialize(layout, seed, parameters));
        for values in [&mut self.gradient[..], &mut self.mean, &mut self.square] {
            values.fill(0.0);
        }
        (self.sum, self.averaged) = (Vec::new(), 0);
        self.grid.reset();
        self.step = 0;
        self.n_rays = self.config.batch_rays.unwrap_or(FIRST_RAYS);
        self.roulette = 0.0;
    }

    /// Sets all parameters at once; whatever follows from them belongs here.
    fn set_parameters(&mut self, set: impl FnOnce(&Layout, &mut [f32])) {
        set(&self.layout, &mut self.parameters);
        let Self { level, parameters, half, .. } = self;
        dispatch!(*level, simd => round_all(simd, parameters, half));
    }

    fn update_occupancy(&mut self) {
        let Self { grid, layout, config, half, level, backward, limits, workers, seed, .. } = self;
        let field = layout.view_half(&config.field, half).expect("checked when training began");
        let new = || Worker::new(*limits, backward);
        let step = self.sampling.step;
        match &field {
            AnyField::HashGrid(field) => {
                grid.update::<F16, _>(*level, field, *seed, step, workers, new);
            }
            AnyField::Frequency(field) => {
                grid.update::<F16, _>(*level, field, *seed, step, workers, new);
            }
            _ => unreachable!("kinds that this crate lays out"),
        }
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
            roulette: if settings.kept < 1.0 { self.roulette } else { 0.0 },
            stopwatch: self.stopwatch.as_ref(),
        };
        let field = self.layout.view_half(&self.config.field, &self.half);
        let field = field.expect("checked when training began");
        let (seed, step) = (self.seed, u64::from(self.step));
        let (level, limits, n_rays) = (self.level, self.limits, self.n_rays);
        let (source, aim) = (&self.source, &self.aim);
        self.groups.par_iter_mut().enumerate().with_max_len(1).for_each(|(g, group)| {
            let mut worker = self.workers.take(|| Worker::new(limits, &self.backward));
            let n = (g + 1) * n_rays / GROUPS - g * n_rays / GROUPS;
            let mut laps = Laps::begin(job.stopwatch);
            group.draw(source, aim, n, Random::new(seed, [1, step, g as u64]));
            laps.end(Stage::Aim, n);
            run_group::<F16>(level, group, &field, &job, &mut worker);
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

/// `T` is how `field` stores its parameters.
fn run_group<T: Store>(
    level: Level,
    group: &mut Group,
    field: &AnyField<'_>,
    job: &Job<'_>,
    worker: &mut Worker,
) {
    fn run<T: Store, F: Field>(
        level: Level,
        group: &mut Group,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        dispatch!(level, simd => group.run::<_, T, F>(simd, field, job, worker));
    }
    match field {
        AnyField::HashGrid(field) => run::<T, _>(level, group, field, job, worker),
        AnyField::Frequency(field) => run::<T, _>(level, group, field, job, worker),
        _ => unreachable!("kinds that this crate lays out"),
    }
}

/// Every cell of the cube that lies in the box of the space.
fn all_cells(space: &Space, resolution: u32) -> Vec<u32> {
    let n = resolution;
    let map = space.unit_map();
    let Space::Box { max, .. } = space else { return (0..n * n * n).collect() };
    let end = map.apply(*max).map(|u| (u * n as f32).ceil() as u32);
    let inside = |cell: &u32| {
        let corner = [cell % n, cell / n % n, cell / (n * n)];
        (0..3).all(|a| corner[a] < end[a])
    };
    (0..n * n * n).filter(inside).collect()
}
