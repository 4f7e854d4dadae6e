//! The training loop: rays → march → shade → back → scatter → new parameters.

pub(crate) mod backend;
mod config;
mod device;
mod finish;
mod gains;
pub(crate) mod held_out;
pub(crate) mod loss;
mod occupancy;
mod optim;
pub(crate) mod parameters;
mod photographs;
pub(crate) mod pixels;
pub(crate) mod poses;
pub mod prepass;
mod run;
mod shape;
mod snapshot;
pub(crate) mod step;

use pocketnerf_core::{ColorSpace, Display, Error, Model, Sampling, SimdLevel, Space};

pub use config::TrainConfig;
pub use finish::Finished;
pub use finish::budget::FinishingBudget;
pub use finish::color_jumps::share as color_jumps;
pub use finish::photos::Disagreement;
pub use held_out::HeldOutPsnr;
pub(crate) use occupancy::cells::all_cells;
pub use occupancy::cells::{dilated, pack};
pub use occupancy::density_grid::DensityGrid;
pub(crate) use occupancy::density_grid::PERIOD as OCCUPANCY_PERIOD;
pub use optim::adam::{Adam, Slices};
pub(crate) use optim::muon;
pub use optim::schedule::{Length, Plan};
pub use pixels::Targets;
pub use pixels::rays::{Backdrop, RaySource, TrainingRay};
pub use prepass::scene_box::find_box;
pub use prepass::scene_contracted::contracted_of;
pub use prepass::scene_ndc::ndc_of;
pub use prepass::visual_hull::VisualHull;
pub use run::checkpoint::{self, Checkpoint, CheckpointError};
pub use run::guard::{Diverged, MAX_RESTARTS, Trouble};
pub use run::size::Size;
pub use run::watch::Overfitted;
pub use run::{NoTime, Progress, Run, RunError, Summary, run};
pub use step::{StepSettings, StepStats};

use crate::dataset::Dataset;
use crate::picture::Device;
use crate::stopwatch::Stopwatch;
use backend::{Backend, Cpu};
use held_out::HeldOut;
use occupancy::clearing::Clearing;
use parameters::{ParameterGroup, State};
use photographs::learnt_gains;
use pixels::importance::PixelSampler;
use pixels::visibility::PixelVisibility;
use poses::Poses;
use prepass::{Deadline, Prepared, PrepassError};
use run::guard;

/// Shares that a step is cut into, at any number of threads.
pub const GROUPS: usize = 16;
/// Rays of the first step, where their number adapts itself.
const FIRST_RAYS: usize = 1024;
/// Rays of a step at most, where the user sets their number.
pub const MAX_BATCH_RAYS: usize = 1 << 20;

/// Samples of a step of the machine that settings are chosen for.
pub(crate) const USUAL_SAMPLES: usize = 1 << 15;
/// Steps that are timed to find a machine's pace.
const PACE_STEPS: u32 = 16;

/// What trains the field of a configuration, with the poses and the gains of so many photographs
/// where these are learnt.
fn backend(
    config: &TrainConfig,
    space: &Space,
    poses: Option<&Poses>,
    evened_out: Option<usize>,
    simd: SimdLevel,
) -> Result<Cpu, Error> {
    let field = config.field.kind().build(space.unit_map().scale);
    let state = State::new(ParameterGroup::of_field(field.layout(), config.adam()));
    let state = state.with(poses.map(Poses::group)).with(evened_out.map(gains::group));
    Cpu::new(field, state, simd)
}

/// A field in training.
#[derive(Debug)]
pub struct Trainer {
    config: TrainConfig,
    /// What holds the parameters and takes the steps.
    backend: Box<dyn Backend>,
    source: RaySource,
    visibility: PixelVisibility,
    sampler: PixelSampler,
    /// Views that are not learnt from now.
    held_out: HeldOut,
    /// Views that were not learnt from before.
    returned: HeldOut,
    /// The field's parameters when those views were rendered best.
    best: Option<Vec<f32>>,
    targets: Targets,
    /// The cameras as they were given, where their poses are refined.
    poses: Option<Poses>,
    /// Whether silhouettes show where the scene is empty.
    has_silhouettes: bool,
    space: Space,
    sampling: Sampling,
    /// Where less light than this passes, samples stand for several steps.
    coarse_step_below: f32,
    grid: DensityGrid,
    /// From which density on its cells are occupied.
    clearing: Clearing,
    step: u32,
    n_rays: usize,
    /// Gradient magnitude below which the roulette plays.
    roulette: f32,
    /// How often training has restarted.
    restarts: u32,
    /// Where this attempt's random numbers begin.
    seed: u64,
    /// Where the time of the steps is recorded.
    stopwatch: Option<Stopwatch>,
    /// What steps are to be taken on, and why the CPU takes them instead.
    device: Device,
    fallback: Option<String>,
}

impl Trainer {
    /// Trains the fields of the prepass, where one is needed, and prepares a run on
    /// `dataset`.
    ///
    /// # Errors
    /// When the configuration does not make a valid field, or the SIMD level is
    /// not there.
    pub fn with_prepass(
        dataset: Dataset,
        config: TrainConfig,
        simd: SimdLevel,
    ) -> Result<Self, PrepassError> {
        Ok(Self::from_prepared(prepass::run(dataset, config, simd, Deadline::NONE)?, simd)?)
    }

    /// Prepares a run; nothing is trained.
    ///
    /// # Errors
    /// As [`with_prepass`](Self::with_prepass).
    pub fn from_prepared(prepared: Prepared, simd: SimdLevel) -> Result<Self, Error> {
        let Prepared { source, space, candidates, hull, mut config } = prepared;
        let sampling = config.sampling(&space)?;
        let n_levels = config.field.kind().n_levels();
        let refined = config.refine_poses && n_levels > 0;
        let poses = refined.then(|| Poses::new(source.cameras(), &space, n_levels)).flatten();
        let gains = learnt_gains(&source, &config);
        let resolution = config.occupancy_resolution;
        let grid = DensityGrid::new(resolution, candidates.clone());
        if let Some(field) = config.field.kind().within(&grid.view()) {
            config.field = field;
        }
        let backend = backend(&config, &space, poses.as_ref(), gains, simd)?;
        // Coordinates that hold all that the cameras see: every tile sees something.
        let seen = if space.scene_box().is_some() { &candidates[..] } else { &[] };
        let visibility = PixelVisibility::new(&source, &space, resolution, seen);
        let mut trainer = Self {
            backend: Box::new(backend),
            targets: source.targets(&visibility),
            source,
            sampler: PixelSampler::new(visibility.n_tiles()),
            held_out: HeldOut::default(),
            returned: HeldOut::default(),
            best: None,
            visibility,
            poses,
            has_silhouettes: hull.is_some(),
            space,
            sampling,
            coarse_step_below: step::COARSE_STEP_BELOW,
            grid,
            clearing: Clearing::NONE,
            step: 0,
            n_rays: FIRST_RAYS,
            roulette: 0.0,
            restarts: 0,
            seed: config.seed,
            stopwatch: None,
            device: Device::Cpu,
            fallback: None,
            config,
        };
        trainer.begin(0);
        Ok(trainer)
    }

    /// Steps of the usual number of samples a second that this machine takes now, from a few
    /// steps, which are undone. That number hardly changes in a run, and with it the time.
    pub fn pace(&mut self) -> f64 {
        let settings = StepSettings {
            rate: 0.0,
            decay: 0.0,
            smoothing: 0.0,
            step_scale: self.config.first_step_scale,
            kept: self.config.kept[0],
            update_occupancy: false,
            average: false,
            between_views: false,
            spread: 0.0,
            progress: 0.0,
        };
        // The first few find out how many rays have so many samples.
        (0..PACE_STEPS / 4).for_each(|_| _ = self.step(&settings));
        let begun = std::time::Instant::now();
        (0..PACE_STEPS).for_each(|_| _ = self.step(&settings));
        let share = self.config.samples_per_step as f64 / USUAL_SAMPLES as f64;
        let pace = share * f64::from(PACE_STEPS) / begun.elapsed().as_secs_f64().max(1e-9);
        self.begin(0);
        pace
    }

    /// The model as it stands.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        Model {
            field: self.backend.field(),
            space: self.space,
            occupancy: Some(self.grid.view()),
            sampling: self.sampling,
            hierarchical: self.config.field.kind().hierarchical_sampling(),
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

    /// How often training has restarted.
    #[must_use]
    pub const fn restarts(&self) -> u32 {
        self.restarts
    }

    /// The occupancy as it stands.
    #[must_use]
    pub const fn occupancy(&self) -> &DensityGrid {
        &self.grid
    }

    /// From now on the time of each stage is recorded.
    pub fn watch(&mut self) {
        self.stopwatch = Some(Stopwatch::default());
    }

    /// What has been recorded since then.
    pub fn stopwatch(&self) -> Option<&Stopwatch> {
        self.stopwatch.as_ref()
    }

    /// Begins the `restarts`-th attempt after the first: each has random numbers
    /// of its own.
    fn begin(&mut self, restarts: u32) {
        self.restarts = restarts;
        self.seed = guard::seed(self.config.seed, restarts);
        self.backend.reset(self.seed);
        self.correct_photographs();
        self.grid.reset();
        self.clearing = Clearing::NONE;
        self.sampler = PixelSampler::new(self.visibility.n_tiles());
        self.leave_out();
        self.best = None;
        self.step = 0;
        self.n_rays = self.config.batch_rays.unwrap_or(FIRST_RAYS);
        self.roulette = 0.0;
    }

    /// From now on a few views are not learnt from; gives how many.
    pub(crate) fn hold_out(&mut self) -> usize {
        self.held_out = HeldOut::choose(&self.source, self.config.seed);
        self.leave_out();
        self.held_out.len()
    }

    /// All views are learnt from again.
    pub(crate) fn return_views(&mut self) {
        self.best = None;
        self.returned = std::mem::take(&mut self.held_out);
        self.leave_out();
    }

    /// Keeps the parameters.
    pub(crate) fn remember(&mut self) {
        self.best = Some(self.backend.parameters().to_vec());
    }

    /// The parameters become what was remembered, and their average begins anew.
    pub(crate) fn go_back(&mut self) {
        let Some(best) = self.best.take() else { return };
        let mut state = self.backend.download().clone();
        state.averaged = 0;
        state.groups.iter_mut().for_each(|group| group.sum = Vec::new());
        state.field_mut().parameters.copy_from_slice(&best);
        self.backend.upload(state);
    }

    fn leave_out(&mut self) {
        let Self { sampler, visibility, held_out, .. } = self;
        sampler.leave_out(|tile| held_out.has(visibility.view(tile)));
    }

    /// How close the field comes to the views that are held out, if there are any.
    pub(crate) fn look_at_held_out(&self) -> Option<HeldOutPsnr> {
        self.held_out.look(&self.model(), self.backend.simd()).ok().flatten()
    }

    /// Ends the run: the parameters become their average over its last part.
    pub fn finish(&mut self) {
        if self.backend.download().averaged > 0 {
            let mut averaged = self.backend.download().averaged();
            if self.is_coarse() {
                averaged.scales.clone_from(&self.backend.download().scales);
            }
            self.backend.upload(averaged);
            self.correct_photographs();
        }
        self.keep_gains();
    }
}
