//! How a run begins: its scene found, its detail fitted to the machine.

use std::time::{Duration, Instant};

use pocketnerf_core::SimdLevel;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer::prepass::{self, Deadline, PrepassError};
use pocketnerf_train::trainer::{Checkpoint, Length, NoTime, TrainConfig, Trainer};

use super::kinds::Images;
use super::scene::Exposure;
use super::{Bar, Train, opened};
use crate::commands::Failure;
use crate::commands::device::Opening;
use crate::commands::stop::Stop;

/// Runs of fewer seconds have the least detail on any machine, whose pace need not be measured.
const MEASURED: f64 = 30.0;
/// Steps a second of a whole run, as a share of those at its beginning: later rays end at
/// surfaces, so that more of them share a step's samples.
const LATER: f64 = 0.6;
/// Runs of fewer seconds have no time to look at the box that they are given, nor at exposure.
const LOOKED_AT: f64 = 10.0;
/// Share of a timed run that may go into looking at exposure.
const LOOKING: f64 = 0.1;
/// Stops from which on evening out does not help enough: the brightest and the darkest parts of
/// photographs are lost.
const EVENED_OUT: f32 = 0.2;

impl Train {
    /// The trainer of a new run, its scene found; the user hears of a box that does not fit it.
    pub(super) fn new_trainer(
        &self,
        dataset: Dataset,
        (level, device): (SimdLevel, Opening),
        (started, stop): (Instant, &Stop),
        bar: &mut Bar,
    ) -> Result<Trainer, Failure> {
        let (config, images) = (self.config(&dataset)?, Images::of(&dataset));
        let teachers = self.checked_teachers(&dataset, &config)?;
        let mut is_uneven = false;
        let is_given = config.aabb.or(dataset.aabb).is_some();
        let seconds = match self.length() {
            Length::Seconds(seconds) => Some(seconds),
            Length::Steps(_) => None,
        };
        let end = seconds.and_then(|seconds| started.checked_add(Duration::from_secs_f64(seconds)));
        let deadline = end.map_or(Deadline::NONE, Deadline::at);
        let failure = |error| -> Failure {
            match (error, seconds) {
                (PrepassError::OutOfTime, Some(seconds)) => {
                    NoTime { seconds, before: started.elapsed().as_secs_f64() }.into()
                }
                (error, _) => error.into(),
            }
        };
        let mut prepared = prepass::run(dataset, config, level, deadline).map_err(failure)?;
        let has_time = seconds.is_none_or(|seconds| seconds >= LOOKED_AT);
        if is_given && has_time {
            let (back, fit) = prepared.box_fit(level, deadline).map_err(failure)?;
            prepared = back;
            if let Some(fit) = fit.filter(|fit| fit.is_doubtful()) {
                bar.warn(fit.to_string());
            }
        }
        if self.scene.exposure != Some(Exposure::Off) && has_time {
            let share = seconds.map(|seconds| Duration::from_secs_f64(LOOKING * seconds));
            let enough = share.and_then(|share| Instant::now().checked_add(share));
            let enough = enough.map_or(Deadline::NONE, Deadline::at);
            let (back, stops) = prepared.even_exposure(level, enough)?;
            prepared = back;
            is_uneven = stops.is_some();
            if let Some(stops) = stops {
                let found = format!(
                    "photographs differ by {stops:.2} stops in exposure or white balance and are \
                     evened out"
                );
                match stops < EVENED_OUT {
                    true => bar.say(&format!("{found}; --exposure off keeps them")),
                    false => bar.warn(format!(
                        "{found}, expected less than {EVENED_OUT} stops: what is too bright in all is lost; \
                         take them with one exposure"
                    )),
                }
            }
        }
        let teachers = self.teachers_of_even(teachers, is_uneven)?;
        let prepared = self.taught(prepared, teachers, (level, stop), bar)?;
        let mut trainer = Trainer::from_prepared(prepared, level)?;
        trainer.begin_on(opened(device, bar));
        if teachers == 0 {
            self.fit_detail(&mut trainer, images)?;
        }
        Ok(trainer)
    }

    /// The vector instructions to go on with: those given, else those of the steps so far, so
    /// that the model is the same to the byte.
    pub(super) fn level_to_resume(&self, checkpoint: &Checkpoint, bar: &mut Bar) -> SimdLevel {
        let before = checkpoint.simd();
        let same = before.filter(|level| level.is_available());
        let level = self.vectors.simd.or(same).unwrap_or_else(SimdLevel::detect);
        if let Some(before) = before.filter(|before| *before != level) {
            bar.warn(format!(
                "{}: trained with {before} so far, resumed with {level}: the model will differ by \
                 rounding; expected --simd {before} for the same bytes",
                checkpoint.file().display()
            ));
        }
        level
    }

    /// Fits the detail of a new timed run to the steps that this machine has time for.
    fn fit_detail(&self, trainer: &mut Trainer, images: Images) -> Result<(), Failure> {
        let config = trainer.config();
        let contracted = config.contracted;
        let in_box = config.ndc.is_none() && contracted.is_none();
        let method = self.method(in_box && images.has_alpha);
        match self.length() {
            Length::Seconds(seconds)
                if seconds >= MEASURED && self.model.follow_steps(method, images) =>
            {
                let steps = Length::Steps((LATER * seconds * trainer.pace()) as u32);
                let fitted = self.model.config(method, images, steps);
                let TrainConfig { field, samples_per_side, .. } = match contracted {
                    Some(space) => fitted.contracted(space, steps),
                    None => fitted,
                };
                let config = trainer.config();
                if (&field, samples_per_side) != (&config.field, config.samples_per_side) {
                    trainer.reshape(field, samples_per_side)?;
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
