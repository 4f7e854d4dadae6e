//! A GPU's backend: the CPU draws rays; all else happens in the GPU's memory. A step is begun before
//! it is known what became of the one before, so that neither waits for the other.

use std::collections::VecDeque;
use std::sync::OnceLock;
use std::time::Duration;

use pocketnerf_core::{AnyField, SimdLevel};
use pocketnerf_gpu::training::{Learner, Learnt, RayResult, StepResult, UnderWay};
use pocketnerf_gpu::{Error, Gpu};

use super::drawing::{Drawing, Origin};
use super::learner::{Scene, learner};
use super::settings::settings;
use super::{Backend, Cpu, StepInput, StepOutput, self_test};
use crate::field::rounding::EightBits;
use crate::trainer::DensityGrid;
use crate::trainer::parameters::State;

/// Steps after which what is learnt is fetched, so that no more is lost with the GPU.
const FETCH_EVERY: u32 = 512;
/// Steps that may be under way when the next one is begun.
const UNDER_WAY: usize = 1;

/// A field on a GPU.
#[derive(Debug)]
pub(crate) struct OnGpu {
    learner: Learner,
    /// What was learnt when it was fetched last, and what goes on where the GPU fails.
    cpu: Cpu,
    /// All that is learnt as it is now, once it is asked for.
    fetched: OnceLock<State>,
    /// The same of the parameters alone.
    parameters: OnceLock<Vec<f32>>,
    drawing: Drawing,
    under_way: VecDeque<Asked>,
    /// Steps whose parameters count in the average.
    averaged: u32,
    /// Whether all parameters are finite.
    is_finite: bool,
    /// Why the CPU goes on.
    failure: Option<Error>,
    /// How long each kernel has taken so far, where steps are timed.
    times: Vec<(&'static str, Duration)>,
}

/// A step that the GPU has been asked for.
#[derive(Debug)]
struct Asked {
    step: UnderWay,
    /// Where its rays come from.
    drawn: Vec<Origin>,
    roulette: f32,
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
            parameters: OnceLock::new(),
            is_finite: true,
            averaged: 0,
            under_way: VecDeque::new(),
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

    /// All of a state.
    fn take_over(&mut self, state: State) -> Result<(), Error> {
        self.under_way.clear();
        self.cpu.upload(state);
        let group = self.cpu.state.field();
        self.learner.set_learnt(&Learnt {
            parameters: group.parameters.to_vec(),
            mean: group.mean.clone(),
            square: group.square.to_vec(),
            sum: group.sum.clone(),
            scales: self.scales(),
        })?;
        self.averaged = self.cpu.state.averaged;
        (self.fetched, self.parameters) = (OnceLock::new(), OnceLock::new());
        self.is_finite = true;
        Ok(())
    }

    /// How the field's tables are rounded: exponents, and units of a step.
    fn scales(&self) -> Vec<[i32; 2]> {
        let n = self.cpu.field.layout().tables().len();
        let scales = EightBits::all_of(&self.cpu.field.scales(), n).map_or(Vec::new(), |all| all.0);
        scales.iter().map(|s| [s.scale_log2().into(), s.step().into()]).collect()
    }

    /// All that is learnt, from the GPU.
    fn fetch(&self) -> Result<State, Error> {
        let mut state = self.cpu.state.clone();
        let Learnt { parameters, mean, square, sum, scales } = self.learner.learnt()?;
        let n = self.cpu.field.layout().tables().len();
        let is_coarse = self.cpu.state.scales.len() > n;
        let units = scales.iter().map(|[exponent, _]| *exponent as u8);
        let steps = scales.iter().map(|[_, step]| *step as u8).filter(|_| is_coarse);
        state.scales = units.chain(steps).collect();
        state.averaged = self.averaged;
        let group = state.field_mut();
        group.parameters.copy_from_slice(&parameters);
        group.square.copy_from_slice(&square);
        (group.mean, group.sum) = (mean, sum);
        Ok(state)
    }

    /// What was fetched since the last step is kept.
    fn keep_fetched(&mut self) {
        self.parameters.take();
        if let Some(state) = self.fetched.take() {
            self.cpu.state = state;
        }
    }

    fn try_step(&mut self, input: &StepInput<'_>) -> Result<StepOutput, Error> {
        self.keep_fetched();
        self.begin(input)?;
        let is_watched = input.stopwatch.is_some();
        let most = if is_watched { 0 } else { UNDER_WAY };
        let mut output = StepOutput::default();
        while self.under_way.len() > most {
            output = self.oldest()?;
        }
        if (input.step + 1).is_multiple_of(FETCH_EVERY) {
            self.cpu.state = self.fetch()?;
        }
        Ok(output)
    }

    /// Has the GPU take a step, and draws rays for the next one.
    fn begin(&mut self, input: &StepInput<'_>) -> Result<(), Error> {
        let settings = settings(input, self.cpu.state.field().adam);
        if input.stopwatch.is_some() {
            self.learner.watch()?;
        }
        let (pixels, origins) = self.drawing.draw(input);
        let step = self.learner.begin(pixels, &settings)?;
        let drawn = origins.to_vec();
        self.under_way.push_back(Asked { step, drawn, roulette: input.roulette });
        self.averaged += u32::from(input.average);
        self.drawing.draw_ahead(input);
        Ok(())
    }

    /// What became of the step that was begun first.
    fn oldest(&mut self) -> Result<StepOutput, Error> {
        let Some(Asked { step, drawn, roulette }) = self.under_way.pop_front() else {
            return Ok(StepOutput::default());
        };
        let result = self.learner.result(step)?;
        self.note_times(&result);
        self.is_finite &= result.is_finite;
        let mut output = StepOutput { rays: result.rays.len(), roulette, ..Default::default() };
        for ((tile, weight), found) in drawn.into_iter().zip(&result.rays) {
            let RayResult { squared_error, opacity, gradient_size, samples, kept } = *found;
            let weight = f64::from(weight);
            output.squared_error += weight * 3.0 * f64::from(squared_error);
            output.opacity += weight * f64::from(opacity);
            output.gradient_size += f64::from(gradient_size);
            output.samples += samples as usize;
            output.kept += kept as usize;
            output.errors.push((tile, squared_error));
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

    /// The CPU goes on from what was fetched last.
    fn give_up(&mut self, why: Error) {
        self.under_way.clear();
        self.keep_fetched();
        let state = self.cpu.state.clone();
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

    fn wait(&mut self) -> StepOutput {
        let mut output = StepOutput::default();
        while !self.under_way.is_empty() {
            match self.oldest() {
                Ok(found) => output = found,
                Err(why) => self.give_up(why),
            }
        }
        output
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
        if self.failure.is_some() { self.cpu.is_finite(tables) } else { self.is_finite }
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

    fn parameters(&self) -> &[f32] {
        if let (None, None) = (&self.failure, self.fetched.get()) {
            let found = self.parameters.get_or_init(|| {
                // Where it fails, the next step notices.
                self.learner.parameters().unwrap_or_default()
            });
            if !found.is_empty() {
                return found;
            }
        }
        &self.download().field().parameters
    }

    fn field(&self) -> AnyField<'_> {
        let field = self.cpu.field.view(self.parameters());
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
