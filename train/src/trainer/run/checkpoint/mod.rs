//! A run on disk, to be resumed as if it had never been interrupted.
//!
//! A checkpoint is a model file in f32, so that whatever reads models reads
//! checkpoints, with the trainer's state in sections of its own that readers
//! of models skip. It holds no image: a run resumes on the dataset that it began
//! with, which its fingerprint proves.
//!
//! With the same steps, SIMD level and build, a run that was interrupted gives
//! the same model, to the bit, as one that was not.

mod error;
pub mod kind;
mod record;
mod sections;

use std::path::{Path, PathBuf};
use std::time::Instant;

use pocketnerf_core::{Sampling, SimdLevel, Space};
use pocketnerf_formats::{About, ContainerWriter, Precision, Scene, SectionId, World, WriteError};

pub use error::{CheckpointError, Problem};
pub use kind::section_name;

use crate::dataset::Dataset;
use crate::trainer::occupancy::clearing::Clearing;
use crate::trainer::prepass::{self, Deadline};
use crate::trainer::run::guard::{self, Averages};
use crate::trainer::run::watch::Watch;
use crate::trainer::{Length, Plan, Run, TrainConfig, Trainer};
use record::RecordV1;
use sections::V1;

/// Which images a run learns from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrainedOn {
    /// [`Dataset::fingerprint`].
    pub fingerprint: u64,
    /// How many times smaller than on disk the images are.
    pub downscale_factor: u32,
}

/// What was read from a checkpoint: sound in itself, not yet held against a dataset.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    file: PathBuf,
    config: TrainConfig,
    space: Space,
    sampling: Sampling,
    /// From the run's coordinates to the dataset's.
    scene: Scene<'static>,
    world: World,
    /// The model files whose mean is learnt beside the photographs.
    teachers: Vec<Vec<u8>>,
    /// Name of the dataset, for people.
    dataset: String,
    record: RecordV1,
    parameters: Vec<f32>,
    mean: Vec<f32>,
    square: Vec<f32>,
    sum: Vec<f32>,
    density: Vec<f32>,
    /// From which density on its cells are occupied.
    clearing: Clearing,
    /// How tables are rounded; empty: as finely as holds them.
    scales: Vec<u8>,
    /// Errors, then sizes.
    sampler: Option<Vec<f32>>,
    /// What was seen of the held-out views.
    watch: Watch,
    /// The parameters with which they were rendered best.
    best: Option<Vec<f32>>,
    /// The vector instructions of the steps so far.
    simd: Option<SimdLevel>,
    /// How photographs are evened out.
    gains: Vec<[f32; 3]>,
    /// What is learnt of them beside the field.
    of_photographs: Vec<Learnt>,
    coarse: Vec<u8>,
    fine: Vec<u8>,
}

/// A group of parameters that the model does not hold.
#[derive(Clone, Debug)]
struct Learnt {
    /// The section of the parameters.
    kind: u32,
    parameters: Vec<f32>,
    mean: Vec<f32>,
    square: Vec<f32>,
    sum: Vec<f32>,
}

/// The bytes of a checkpoint. `about` is what the model would be written with.
///
/// # Errors
/// What writing a model may report: a weight that is not finite.
pub fn write(
    trainer: &Trainer,
    run: &Run,
    trained_on: TrainedOn,
    about: &About<'_>,
) -> Result<Vec<u8>, WriteError> {
    let mut writer = ContainerWriter::new();
    writer.add_model(&trainer.model(), about, Precision::F32)?;
    let field = trainer.config.field.kind().section();
    let mut add = |kind, bytes| writer.add(SectionId::first(kind), V1, false, bytes);
    let record = RecordV1::new(trainer, run, trained_on).to_bytes();
    add(kind::TRAINER, &record[..]);
    let state = trainer.backend.download();
    for group in &state.groups {
        if let Some(parameters) = group.sections.parameters {
            add(parameters, bytemuck::must_cast_slice(&group.parameters));
        }
        add(group.sections.mean, bytemuck::must_cast_slice(&group.mean));
        add(group.sections.square, bytemuck::must_cast_slice(&group.square));
    }
    add(kind::DENSITY, bytemuck::must_cast_slice(trainer.grid.state().0));
    add(kind::SCALES, &state.scales);
    let sampler = trainer.sampler.state().concat();
    add(kind::PIXEL_ERRORS, bytemuck::must_cast_slice(&sampler));
    // A vector grows and the struct has a known length: nothing can fail.
    let watch = postcard::to_extend(&run.watch, Vec::new()).unwrap_or_default();
    add(kind::WATCH, &watch);
    if let Some(best) = &trainer.best {
        add(kind::BEST, bytemuck::must_cast_slice(best));
    }
    add(kind::SIMD, trainer.backend.simd().name().as_bytes());
    let gains = trainer.source.exposure().gains();
    if !gains.is_empty() {
        add(kind::EXPOSURE, bytemuck::must_cast_slice(gains));
    }
    let smooth = trainer.config.smooth_surfaces.to_le_bytes();
    if trainer.config.smooth_surfaces > 0.0 {
        add(kind::SMOOTH_SURFACES, &smooth);
    }
    let clearing = trainer.clearing.to_bytes();
    if trainer.config.clear_fog {
        add(kind::CLEARING, &clearing);
    }
    if let Some(field) = &field {
        add(kind::KIND, field);
    }
    for group in state.groups.iter().filter(|_| state.averaged > 0) {
        add(group.sections.sum, bytemuck::must_cast_slice(&group.sum));
    }
    for (index, teacher) in (0..).zip(trainer.source.teachers()) {
        writer.add(SectionId { kind: kind::TEACHER, index }, V1, false, teacher);
    }
    writer.finish()
}

impl Checkpoint {
    /// Reads a checkpoint, every byte checked.
    ///
    /// # Errors
    /// One line: which file, what was found, what was expected, what to do.
    pub fn read(file: &Path) -> Result<Self, CheckpointError> {
        let bytes = std::fs::read(file).map_err(|e| Problem::Unreadable(e).of(file))?;
        Self::from_bytes(file, &bytes)
    }

    /// As [`Checkpoint::read`], from bytes; `file` is what errors call them.
    ///
    /// # Errors
    /// As [`Checkpoint::read`].
    pub fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Self, CheckpointError> {
        sections::read(file, bytes).map_err(|problem| problem.of(file))
    }

    /// The file it was read from.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The run's settings.
    #[must_use]
    pub const fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// The images that the run learns from.
    #[must_use]
    pub const fn trained_on(&self) -> TrainedOn {
        self.record.trained_on()
    }

    /// From the run's coordinates to those of the dataset's files.
    #[must_use]
    pub const fn scene(&self) -> &Scene<'static> {
        &self.scene
    }

    /// What is known of the coordinates of the dataset's files.
    #[must_use]
    pub const fn world(&self) -> World {
        self.world
    }

    /// How long the run was to be.
    #[must_use]
    pub const fn length(&self) -> Length {
        self.record.length()
    }

    /// The run's steps, where they are fixed already.
    #[must_use]
    pub fn plan(&self) -> Option<Plan> {
        self.record.plan()
    }

    /// Steps taken.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        self.record.step
    }

    /// How often training has restarted.
    #[must_use]
    pub const fn restarts(&self) -> u32 {
        self.record.restarts
    }

    /// The vector instructions of the steps so far, where that is known: with others the run
    /// ends with a model that differs by rounding.
    #[must_use]
    pub const fn simd(&self) -> Option<SimdLevel> {
        self.simd
    }

    /// Whether photographs are evened out.
    #[must_use]
    pub const fn is_evened_out(&self) -> bool {
        !self.gains.is_empty()
    }

    /// How many teachers the run learns from.
    #[must_use]
    pub const fn n_teachers(&self) -> usize {
        self.teachers.len()
    }

    /// Seconds that the run has taken so far.
    #[must_use]
    pub const fn elapsed(&self) -> f64 {
        self.record.elapsed
    }

    /// The trainer and the run as they were, on the dataset they were on.
    /// `started` is when this program began.
    ///
    /// # Errors
    /// [`Problem::Dataset`] where the dataset is another, [`Problem::Model`] or
    /// [`Problem::Changed`] where this build makes something else of it.
    pub fn resume(
        self,
        dataset: Dataset,
        simd: SimdLevel,
        started: Instant,
    ) -> Result<(Trainer, Run), CheckpointError> {
        let file = self.file.clone();
        self.resumed(dataset, simd, started).map_err(|problem| problem.of(&file))
    }

    fn resumed(
        self,
        dataset: Dataset,
        simd: SimdLevel,
        started: Instant,
    ) -> Result<(Trainer, Run), Problem> {
        let (expected, found) = (self.record.fingerprint, dataset.fingerprint());
        if expected != found {
            let (name, given) = (self.dataset, dataset.source);
            return Err(Problem::Dataset { name, given, expected, found });
        }
        let record = self.record;
        let changed = |part, same: bool| if same { Ok(()) } else { Err(Problem::Changed(part)) };
        let prepared = prepass::run(dataset, self.config, simd, Deadline::NONE);
        let mut prepared = prepared.map_err(Problem::Model)?;
        let (gains, views) = (self.gains.len(), prepared.source.cameras().len());
        changed("number of photographs", gains == 0 || gains == views)?;
        prepared.source.even_out(self.gains);
        if !self.teachers.is_empty() {
            let taught = prepared.source.learn_from(self.teachers, simd);
            taught.map_err(|_| Problem::State("section TEACHER"))?;
        }
        let mut trainer =
            Trainer::from_prepared(prepared, simd).map_err(|e| Problem::Model(e.into()))?;
        changed("scene box", trainer.space == self.space)?;
        changed("steps along a ray", trainer.sampling == self.sampling)?;
        let mut state = trainer.backend.download().clone();
        let group = state.field_mut();
        let same = group.parameters.len() == self.parameters.len();
        changed("number of parameters", same)?;
        group.parameters.copy_from_slice(&self.parameters);
        group.mean = self.mean;
        group.square.copy_from_slice(&self.square);
        group.sum = self.sum;
        for Learnt { kind, parameters, mean, square, sum } in self.of_photographs {
            let Some(group) = state.group_mut(kind) else { continue };
            changed("number of photographs", parameters.len() == group.parameters.len())?;
            group.parameters.copy_from_slice(&parameters);
            group.square.copy_from_slice(&square);
            (group.mean, group.sum) = (mean, sum);
        }
        (state.averaged, state.scales) = (record.averaged, self.scales);
        trainer.backend.upload(state);
        trainer.correct_photographs();
        let (density, updates) = (&self.density, record.updates);
        let restored = trainer.grid.restore(density, updates, &self.coarse, &self.fine);
        changed("cells that may be occupied", restored)?;
        trainer.clearing = self.clearing;
        if self.watch.holding {
            trainer.hold_out();
            trainer.best = self.best;
        }
        if let Some(sampler) = &self.sampler {
            let restored = trainer.sampler.restore(sampler);
            changed("tiles of the images", restored)?;
        }
        trainer.step = record.step;
        trainer.n_rays = record.n_rays as usize;
        trainer.roulette = record.roulette;
        trainer.restarts = record.restarts;
        trainer.seed = guard::seed(trainer.config.seed, record.restarts);
        let mut run = Run::continued(record.length(), record.plan(), record.elapsed, started);
        let [squared_error, opacity] = record.averages;
        run.averages = Averages { squared_error, opacity };
        (run.rays, run.samples) = (record.rays, record.samples);
        run.watch = self.watch;
        Ok((trainer, run))
    }
}
