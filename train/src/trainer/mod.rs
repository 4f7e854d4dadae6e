//! The training loop: rays → march → shade → back → scatter → new parameters.

mod config;
mod finish;
#[cfg(test)]
mod gradient_tests;
mod occupancy;
mod optim;
mod pixels;
mod prepass;
mod run;
mod step;

use fearless_simd::Level;
use pocketnerf_core::scratch::Limits;
use pocketnerf_core::{ColorSpace, Display, Error, Model, Sampling, SimdLevel, Space};

pub use config::{Paper, TrainConfig};
pub use finish::Finished;
pub use finish::budget::Effort;
pub use occupancy::cells::{dilated, pack};
pub use occupancy::density_grid::OccupancyGrid;
pub(crate) use occupancy::density_grid::PERIOD as OCCUPANCY_PERIOD;
pub use optim::adam::{Adam, Slices};
pub use optim::schedule::{Length, Plan};
pub use pixels::rays::{Backdrop, RaySource, Targets, TrainingRay};
pub use prepass::scene_box::find_box;
pub use prepass::scene_ndc::ndc_of;
pub use prepass::visual_hull::Hull;
pub use run::checkpoint::{self, Checkpoint, CheckpointError};
pub use run::guard::{Diverged, MAX_RESTARTS, Trouble};
pub use run::{Progress, Run, Summary, run};
pub use step::{StepSettings, StepStats};

use crate::aligned::Aligned;
use crate::dataset::Dataset;
use crate::field::{Backward, EncodingConfig, Layout, Rounded, initialize};
use crate::pool::Pool;
use crate::probe::Probe;
use crate::stopwatch::Stopwatch;
use pixels::importance::Attention;
use pixels::visibility::Aim;
use prepass::coarse_field;
use run::guard;
use step::group::{Group, MIN_TRANSMITTANCE, Worker};

/// Shares that a step is cut into, at any number of threads.
pub const GROUPS: usize = 16;
/// Rays of the first step, where their number adapts itself.
const FIRST_RAYS: usize = 1024;
/// Rays of a step at most, where the user sets their number.
pub const MAX_BATCH_RAYS: usize = 1 << 20;

/// A field in training.
#[derive(Debug)]
pub struct Trainer {
    config: TrainConfig,
    simd: SimdLevel,
    level: Level,
    source: RaySource,
    aim: Aim,
    attention: Attention,
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
    /// What asks for densities, as many as there are threads.
    probes: Pool<Probe>,
    mean: Vec<f32>,
    square: Aligned<f32>,
    /// What the forward pass reads.
    rounded: Rounded,
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
        if let EncodingConfig::HashGrid(grid) = &config.field.encoding {
            grid.validate()?;
        }
        let has_alpha = dataset.has_alpha;
        let backdrop = match (config.backdrop, has_alpha) {
            (Some(color), _) => Backdrop::Color(color),
            (None, true) => Backdrop::Random,
            (None, false) => Backdrop::Color(dataset.background.unwrap_or(config.opaque_backdrop)),
        };
        let mut source = RaySource::new(dataset.views, backdrop);
        if let Some(ndc) = config.ndc {
            // All that the cameras see lies there, and silhouettes hide little of it.
            config.aabb = None;
            return Self::in_space(source, None, Space::Ndc(ndc), config, simd);
        }
        config.aabb = config.aabb.or(dataset.aabb);
        let hull = has_alpha.then(|| Hull::new(&source));
        let mut space = match config.aabb {
            Some([min, max]) => Space::Box { min, max },
            None => find_box(source.cameras(), hull.as_ref()),
        };
        if let (None, Some(hull)) = (config.aabb, &hull) {
            (space, source) = coarse_field::tighten(space, source, hull, &config, simd)?;
        }
        // A checkpoint holds it: going on does not look for it again.
        config.aabb = space.scene_box();
        Self::in_space(source, hull.as_ref(), space, config, simd)
    }

    /// Prepares a run in this space.
    fn in_space(
        source: RaySource,
        hull: Option<&Hull>,
        space: Space,
        mut config: TrainConfig,
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        let level = simd.token()?;
        space.validate()?;
        let scale = space.unit_map().scale;
        let step = 1.0 / (scale * config.samples_per_side);
        let far = config.far.unwrap_or(config.near + 64.0 / scale);
        let sampling =
            Sampling { step, near: config.near, far, min_transmittance: MIN_TRANSMITTANCE };
        sampling.validate()?;
        // Density is learnt per unit length of the cube, whatever its size.
        config.field.log_density_bias = scale.ln();
        if let EncodingConfig::Nerf(nerf) = &mut config.field.encoding {
            nerf.density_scale = scale;
        }
        let layout = Layout::new(&config.field);
        let parameters = Aligned::new(layout.len());
        let limits = layout.view(&config.field, &parameters)?.limits();
        let resolution = config.occupancy_resolution;
        let candidates = match hull {
            Some(hull) => hull.cells(&space, resolution),
            None => all_cells(&space, resolution),
        };
        let (candidates, source) = match (config.nerf_field(), config.paper) {
            (Some(_), None) => coarse_field::cells(source, hull, space, &config, simd, candidates)?,
            _ => (candidates, source),
        };
        // Coordinates that hold all that the cameras see: every tile sees something.
        let seen = if space.scene_box().is_some() { &candidates[..] } else { &[] };
        let aim = Aim::new(&source, &space, resolution, seen);
        let backward = Backward::new(&config.field, &layout);
        let n_network = layout.len() - layout.networks_start();
        let group = || Group::new(n_network);
        let mut trainer = Self {
            simd,
            level,
            targets: source.targets(&aim),
            source,
            attention: Attention::new(aim.n_tiles()),
            aim,
            space,
            sampling,
            gradient: vec![0.0; n_network],
            level_gradients: Pool::default(),
            workers: Pool::default(),
            probes: Pool::default(),
            mean: vec![0.0; n_network],
            square: Aligned::new(layout.len()),
            rounded: Rounded::new(&layout),
            sum: Vec::new(),
            averaged: 0,
            adam: config.adam(),
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
            hierarchical: self.config.hierarchical(),
            display: Display {
                background: self.source.display_background(),
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
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
    pub fn watch(&mut self) {
        self.stopwatch = Some(Stopwatch::default());
    }

    /// What has been written down since then.
    pub fn stopwatch(&self) -> Option<&Stopwatch> {
        self.stopwatch.as_ref()
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
        self.attention = Attention::new(self.aim.n_tiles());
        self.step = 0;
        self.n_rays = self.config.batch_rays.unwrap_or(FIRST_RAYS);
        self.roulette = 0.0;
    }

    /// Sets all parameters at once; whatever follows from them belongs here.
    fn set_parameters(&mut self, set: impl FnOnce(&Layout, &mut [f32])) {
        set(&self.layout, &mut self.parameters);
        self.rounded.round(self.level, &self.layout, &self.parameters);
    }
}

/// Every cell of the cube that lies in the box of the space.
pub(crate) fn all_cells(space: &Space, resolution: u32) -> Vec<u32> {
    let n = resolution;
    let map = space.unit_map();
    let [_, max] = space.bounds();
    let end = map.apply(max).map(|u| (u * n as f32).ceil() as u32);
    let inside = |cell: &u32| {
        let corner = [cell % n, cell / n % n, cell / (n * n)];
        (0..3).all(|a| corner[a] < end[a])
    };
    (0..n * n * n).filter(inside).collect()
}
