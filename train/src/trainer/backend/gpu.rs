//! A GPU's backend: the CPU draws rays and updates the networks, which are small; all else
//! happens in the GPU's memory.

use std::sync::OnceLock;
use std::time::Duration;

use pocketnerf_core::{AnyField, SimdLevel};
use pocketnerf_gpu::training::{Learner, RayResult, Settings, StepResult, TableRates, Tables};
use pocketnerf_gpu::{Error, Gpu};

use super::drawing::Drawing;
use super::learner::{Scene, learner};
use super::{Backend, Cpu, StepInput, StepOutput, self_test};
use crate::field::Update;
use crate::field::rounding::EightBits;
use crate::trainer::parameters::State;
use crate::trainer::step::group::MIN_TRANSMITTANCE;
use crate::trainer::step::slow_below::SlowBelow;
use crate::trainer::{Adam, DensityGrid};

/// Steps after which the tables are fetched, so that no more is lost with the GPU.
const FETCH_EVERY: u32 = 512;

/// A field on a GPU.
#[derive(Debug)]
pub(crate) struct OnGpu {
    learner: Learner,
    /// The networks, the tables as they were when they were fetched last, and what goes on where
    /// the GPU fails.
    cpu: Cpu,
    /// All that is learnt as it is now, once it is asked for.
    fetched: OnceLock<State>,
    drawing: Drawing,
    /// Whether all entries of the tables are finite.
    is_finite: bool,
    /// Why the CPU goes on.
    failure: Option<Error>,
    /// How long each kernel has taken so far, where steps are timed.
    times: Vec<(&'static str, Duration)>,
}

impl OnGpu {
    /// Takes over what the CPU has learnt of the field of `model`, seen by cameras at these places,
    /// with about so many samples a step.
    ///
    /// # Errors
    /// Why it cannot; `cpu` is as it was.
    pub(crate) fn new(
        gpu: &Gpu,
        cpu: Cpu,
        scene: Scene<'_>,
        cameras: &[[f32; 3]],
        samples: usize,
    ) -> Result<Self, (Box<Cpu>, Error)> {
        let learner = learner(gpu, &cpu, scene, cameras, samples as u32);
        let learner = match learner {
            Ok(learner) => learner,
            Err(why) => return Err((Box::new(cpu), why)),
        };
        let state = cpu.state.clone();
        let fetched = OnceLock::new();
        let mut own = Self {
            learner,
            cpu,
            fetched,
            is_finite: true,
            drawing: Drawing::default(),
            failure: None,
            times: Vec::new(),
        };
        let sound = own.take_over(state).and_then(|()| self_test::compare(&own.learner, &own.cpu));
        match sound {
            Ok(()) => Ok(own),
            Err(why) => Err((Box::new(own.cpu), why)),
        }
    }

    /// The tables and networks of a state, all at once.
    fn take_over(&mut self, state: State) -> Result<(), Error> {
        self.cpu.upload(state);
        let start = self.cpu.field.layout().networks_start();
        let group = self.cpu.state.field();
        let upto = |values: &[f32]| values.get(..start).unwrap_or_default().to_vec();
        self.learner.set_tables(&Tables {
            parameters: upto(&group.parameters),
            square: upto(&group.square),
            sum: upto(&group.sum),
            scales: self.scales(),
        })?;
        self.fetched = OnceLock::new();
        self.is_finite = true;
        self.show_networks()
    }

    /// How the field's tables are rounded: exponents, and units of a step.
    fn scales(&self) -> Vec<[i32; 2]> {
        let n = self.cpu.field.layout().tables().len();
        let scales = EightBits::all_of(&self.cpu.field.scales(), n).map_or(Vec::new(), |all| all.0);
        scales.iter().map(|s| [s.scale_log2().into(), s.step().into()]).collect()
    }

    /// The GPU sees the networks as they are now.
    fn show_networks(&mut self) -> Result<(), Error> {
        let parameters = &self.cpu.state.field().parameters;
        let field = self.cpu.field.training_view(parameters)?;
        let start = self.cpu.field.layout().networks_start();
        self.learner.set_networks(&field, &parameters[start..])
    }

    /// All that is learnt, from the GPU.
    fn fetch(&self) -> Result<State, Error> {
        let mut state = self.cpu.state.clone();
        let tables = self.learner.tables()?;
        let n = self.cpu.field.layout().tables().len();
        let is_coarse = self.cpu.state.scales.len() > n;
        let units = tables.scales.iter().map(|[exponent, _]| *exponent as u8);
        let steps = tables.scales.iter().map(|[_, step]| *step as u8).filter(|_| is_coarse);
        state.scales = units.chain(steps).collect();
        let group = state.field_mut();
        let n = tables.parameters.len();
        group.parameters[..n].copy_from_slice(&tables.parameters);
        group.square[..n].copy_from_slice(&tables.square);
        if !tables.sum.is_empty() && !group.sum.is_empty() {
            group.sum[..n].copy_from_slice(&tables.sum);
        }
        Ok(state)
    }

    /// What was fetched since the last step is kept.
    fn keep_fetched(&mut self) {
        if let Some(state) = self.fetched.take() {
            self.cpu.state = state;
        }
    }

    fn try_step(&mut self, input: &StepInput<'_>) -> Result<StepOutput, Error> {
        self.keep_fetched();
        let pixels = self.drawing.draw(input);
        let number = input.step + 1;
        let adam = Adam { decay: input.table_decay, beta1: 0.0, ..self.cpu.state.field().adam };
        let rate = adam.corrected(input.table_rate, number);
        let slow = SlowBelow::new(&input.space, input.source.nearest());
        let settings = Settings {
            occupancy: input.occupancy,
            step: input.sampling.step,
            min_transmittance: MIN_TRANSMITTANCE,
            coarse_step_below: input.coarse_step_below,
            roulette: input.roulette,
            tables: TableRates {
                rate,
                kept: 1.0 - rate * adam.decay,
                new: 1.0 - adam.beta2,
                epsilon: adam.epsilon,
            },
            slow_below: slow.map_or(0.0, |slow| slow.distance()),
            seed: (input.seed ^ (input.seed >> 32)) as u32,
            number: input.step,
            blur_directions: input.blur_directions,
            between_views: input.between_views,
            average: input.average,
        };
        if input.stopwatch.is_some() {
            self.learner.watch()?;
        }
        let Self { learner, drawing, .. } = self;
        let result = learner.step(&pixels, &settings, || drawing.draw_ahead(input))?;
        self.note_times(&result);
        self.is_finite &= result.is_finite;
        let output = self.output(&result);
        let group = self.cpu.state.field_mut();
        let update = Update {
            level: self.cpu.level,
            parameters: &mut group.parameters,
            mean: &mut group.mean,
            square: &mut group.square,
            step: number,
            adam: group.adam,
            table_rate: input.table_rate,
            table_decay: input.table_decay,
            rate: input.rate,
            stopwatch: input.stopwatch,
        };
        self.cpu.field.update_networks(update, &result.gradient);
        self.show_networks()?;
        if input.average {
            let start = self.cpu.field.layout().networks_start();
            self.cpu.state.accumulate(start);
        }
        if number.is_multiple_of(FETCH_EVERY) {
            self.cpu.state = self.fetch()?;
        }
        Ok(output)
    }

    fn note_times(&mut self, result: &StepResult) {
        for (name, time) in &result.times {
            match self.times.iter_mut().find(|(other, _)| other == name) {
                Some((_, sum)) => *sum += *time,
                None => self.times.push((name, *time)),
            }
        }
    }

    fn output(&self, result: &StepResult) -> StepOutput {
        let mut output = StepOutput::default();
        for (ray, found) in self.drawing.rays().zip(&result.rays) {
            let RayResult { squared_error, opacity, gradient_size, samples, kept } = *found;
            let weight = f64::from(ray.weight);
            output.squared_error += weight * 3.0 * f64::from(squared_error);
            output.opacity += weight * f64::from(opacity);
            output.gradient_size += f64::from(gradient_size);
            output.samples += samples as usize;
            output.kept += kept as usize;
            output.errors.push((ray.tile, squared_error));
        }
        output
    }

    /// The CPU goes on from what was fetched last. Averages begin anew: their sums of tables and of
    /// networks may be those of other steps.
    fn give_up(&mut self, why: Error) {
        self.keep_fetched();
        let mut state = self.cpu.state.clone();
        state.averaged = 0;
        state.groups.iter_mut().for_each(|group| group.sum = Vec::new());
        self.cpu.upload(state);
        self.failure = Some(why);
    }
}

impl Backend for OnGpu {
    fn reset(&mut self, seed: u64) {
        self.cpu.reset(seed);
        let state = self.cpu.state.clone();
        self.upload(state);
    }

    fn upload(&mut self, state: State) {
        if self.failure.is_some() {
            self.cpu.upload(state);
        } else if let Err(why) = self.take_over(state) {
            self.give_up(why);
        }
    }

    fn download(&self) -> &State {
        // Where it fails, the next step notices.
        let fetch = || self.fetch().unwrap_or_else(|_| self.cpu.state.clone());
        if self.failure.is_some() { &self.cpu.state } else { self.fetched.get_or_init(fetch) }
    }

    fn step(&mut self, input: &StepInput<'_>) -> StepOutput {
        if self.failure.is_none() {
            match self.try_step(input) {
                Ok(output) => return output,
                Err(why) => self.give_up(why),
            }
        }
        self.cpu.step(input)
    }

    fn densities(&self, grid: &mut DensityGrid, seed: u64) {
        if self.failure.is_some() {
            return self.cpu.densities(grid, seed);
        }
        // Where it fails, the next step notices.
        if let Ok(sigmas) = self.learner.densities(&grid.points(seed)) {
            grid.note(&sigmas);
        }
    }

    fn skips_by_table(&self) -> bool {
        self.failure.is_some()
    }

    fn is_finite(&self, tables: bool) -> bool {
        let is_own = self.failure.is_none();
        self.cpu.is_finite(tables && !is_own) && (self.is_finite || !tables)
    }

    fn round_coarsely(&mut self, lengths: &[f32]) {
        self.fetched = OnceLock::from(self.download().clone());
        self.keep_fetched();
        let state = self.cpu.state.clone();
        self.cpu.upload(state);
        self.cpu.round_coarsely(lengths);
        let rounded = self.learner.set_scales(&self.scales());
        if let (Err(why), None) = (rounded, &self.failure) {
            self.give_up(why);
        }
    }

    fn field(&self) -> AnyField<'_> {
        let field = self.cpu.field.view(&self.download().field().parameters);
        field.expect("checked when training began")
    }

    fn simd(&self) -> SimdLevel {
        self.cpu.simd()
    }

    #[cfg(test)]
    fn draw_like_the_cpu(&mut self) {
        self.drawing.like_the_cpu = true;
    }

    #[cfg(test)]
    fn lose(&mut self) {
        self.give_up(Error::Device("it is lost".to_owned()));
    }

    fn kernels(&self) -> Vec<(&'static str, Duration)> {
        self.times.clone()
    }

    fn fallback(&self) -> Option<String> {
        self.failure.as_ref().map(ToString::to_string)
    }
}
