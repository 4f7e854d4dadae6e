//! The processor's backend: groups of rays on all threads, in SIMD lanes.

use fearless_simd::Level;
use pocketnerf_core::scratch::Limits;
use pocketnerf_core::{AnyField, Error, SimdLevel};
use rayon::prelude::*;

use super::{Backend, StepInput, StepOutput};
use crate::field::{Context, TrainableField, Update};
use crate::pool::Pool;
use crate::probe::Probe;
use crate::random::Random;
use crate::stopwatch::{Laps, Stage};
use crate::trainer::parameters::State;
use crate::trainer::run::checkpoint::kind;
use crate::trainer::step::group::{Group, Job};
use crate::trainer::step::worker::Worker;
use crate::trainer::{DensityGrid, GROUPS};

/// Threads, SIMD lanes, and their memory.
#[derive(Debug)]
pub(crate) struct Cpu {
    pub(super) simd: SimdLevel,
    pub(crate) level: Level,
    pub(crate) field: Box<dyn TrainableField>,
    pub(crate) state: State,
    pub(crate) groups: Vec<Group>,
    pub(crate) limits: Limits,
    /// Memory of marching, as much as there are threads.
    workers: Pool<Worker>,
    /// Memory of looking at cells.
    probes: Pool<Probe>,
}

impl Cpu {
    /// For a field and what is learnt of it.
    ///
    /// # Errors
    /// When these do not make a valid field, or the SIMD level is not there.
    pub(crate) fn new(
        field: Box<dyn TrainableField>,
        state: State,
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        let level = simd.token()?;
        let limits = field.view(&state.field().parameters)?.limits();
        Ok(Self {
            simd,
            level,
            field,
            state,
            groups: (0..GROUPS).map(|_| Group::default()).collect(),
            limits,
            workers: Pool::default(),
            probes: Pool::default(),
        })
    }

    /// Forwards and backwards with every group of rays.
    fn run_groups(&mut self, input: &StepInput<'_>) {
        let job = Job::new(input);
        let Self { field, state, workers, level, limits, .. } = self;
        let (field, parameters) = (&**field, &state.field().parameters[..]);
        let context = Context { level: *level, parameters, stopwatch: input.stopwatch };
        let view = field.training_view(parameters).expect("checked when training began");
        self.groups.par_iter_mut().enumerate().with_max_len(1).for_each(|(g, group)| {
            let mut worker = workers.lease(|| Worker::new(*limits));
            let n = (g + 1) * input.n_rays / GROUPS - g * input.n_rays / GROUPS;
            let mut laps = Laps::begin(input.stopwatch);
            let random = Random::new(input.seed, [1, u64::from(input.step), g as u64]);
            group.draw(input, n, random);
            laps.end(Stage::Pixels, n);
            let mut back = field.back(g, context);
            group.run(*level, &view, &job, &mut worker, &mut *back);
        });
    }

    /// New parameters, from the groups' gradients.
    fn update(&mut self, input: &StepInput<'_>) {
        let group = self.state.field_mut();
        self.field.update(Update {
            level: self.level,
            parameters: &mut group.parameters,
            mean: &mut group.mean,
            square: &mut group.square,
            step: input.step + 1,
            adam: group.adam,
            table_rate: input.table_rate,
            table_decay: input.table_decay,
            table_smoothing: input.table_smoothing,
            rate: input.rate,
            stopwatch: input.stopwatch,
        });
        self.state.scales = self.field.scales();
        let (groups, views) = (&self.groups, input.source.cameras().len());
        if let (Some(poses), Some(group)) = (&input.poses, self.state.group_mut(kind::POSES)) {
            let pulls = groups.iter().map(|group| &group.pulls[..]);
            poses.update(group, &sum(pulls, views), input.step + 1);
        }
        if let (Some(gains), Some(group)) = (&input.gains, self.state.group_mut(kind::GAINS)) {
            let gradients = groups.iter().map(|group| &group.d_gains[..]);
            gains.update(group, &sum(gradients, views), input.step + 1);
        }
    }

    fn output(&self, input: &StepInput<'_>) -> StepOutput {
        let (rays, roulette) = (input.n_rays, input.roulette);
        let mut output = StepOutput { rays, roulette, ..StepOutput::default() };
        for group in &self.groups {
            output.squared_error += group.stats.squared_error;
            output.opacity += group.stats.opacity;
            output.samples += group.stats.samples;
            output.kept += group.stats.kept;
            output.gradient_size += group.stats.gradient_size;
        }
        if input.hierarchical.is_none() {
            output.errors = self.groups.iter().flat_map(Group::errors).collect();
        }
        output
    }
}

/// The sum of all groups' gradients of so many views, in the groups' order.
fn sum<'g, const N: usize>(
    groups: impl Iterator<Item = &'g [[f32; N]]>,
    views: usize,
) -> Vec<[f32; N]> {
    let mut sum = vec![[0.0; N]; views];
    for group in groups {
        let values = sum.as_flattened_mut().iter_mut().zip(group.as_flattened());
        values.for_each(|(sum, value)| *sum += value);
    }
    sum
}

impl Backend for Cpu {
    fn reset(&mut self, seed: u64) {
        let mut state = State { averaged: 0, scales: Vec::new(), ..self.state.clone() };
        for group in &mut state.groups {
            group.reset();
        }
        self.field.initialize(seed, &mut state.field_mut().parameters);
        self.upload(state);
    }

    fn upload(&mut self, state: State) {
        let parameters = &state.field().parameters;
        self.field.set(self.level, parameters);
        if !state.scales.is_empty() {
            self.field.restore_scales(self.level, &state.scales, parameters);
        }
        self.state = State { scales: self.field.scales(), ..state };
    }

    fn download(&self) -> &State {
        &self.state
    }

    fn is_finite(&self, tables: bool) -> bool {
        self.state.is_finite(tables)
    }

    fn round_coarsely(&mut self, lengths: &[f32]) {
        self.field.round_coarsely(self.level, lengths, &self.state.field().parameters);
        self.state.scales = self.field.scales();
    }

    fn step(&mut self, input: &StepInput<'_>) -> StepOutput {
        self.field.prepare(&self.state.field().parameters, GROUPS);
        self.run_groups(input);
        let output = self.output(input);
        self.update(input);
        if input.average {
            self.state.accumulate();
        }
        output
    }

    fn densities(&self, grid: &mut DensityGrid, seed: u64) {
        let field = self.field.training_view(&self.state.field().parameters);
        let field = field.expect("checked when training began");
        grid.look(self.level, &field, seed, &self.probes, || Probe::new(self.limits));
    }

    fn field(&self) -> AnyField<'_> {
        let field = self.field.view(&self.state.field().parameters);
        field.expect("checked when training began")
    }

    fn simd(&self) -> SimdLevel {
        self.simd
    }
}
