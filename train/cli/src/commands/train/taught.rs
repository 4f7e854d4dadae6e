//! Runs that learn from fields that were trained before.

use pocketnerf_core::SimdLevel;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer::prepass::Prepared;
use pocketnerf_train::trainer::{Length, TrainConfig};

use super::{Bar, Train};
use crate::commands::Failure;
use crate::commands::stop::{Interrupted, Stop};

/// Teachers of a run that has time for them.
const USUAL: u32 = 2;
/// From so many photographs on, they settle what lies between them.
const FEW: usize = 32;
/// Runs of fewer seconds or steps gain more by going on.
const LONG: (f64, u32) = (480.0, 20_000);
/// Share of a timed run that its teachers take.
const SHARE: f64 = 0.6;

impl Train {
    /// How many teachers a new run on this dataset is to have.
    pub(super) fn n_teachers(&self, dataset: &Dataset) -> u32 {
        let is_long = match self.length() {
            Length::Seconds(seconds) => seconds >= LONG.0,
            Length::Steps(steps) => steps >= LONG.1,
        };
        let is_few = dataset.forward_facing && dataset.views.len() < FEW;
        let can = !dataset.has_alpha && !self.scene.refine_poses;
        // Teachers are trained on the CPU: a GPU would wait.
        let is_worth_it = is_long && is_few && can && !self.device.is_gpu();
        self.scene.teachers.unwrap_or(if is_worth_it { USUAL } else { 0 })
    }

    /// The length of a run with so many teachers, and of each of these.
    pub(super) fn lengths(&self, teachers: u32) -> (Length, Length) {
        match self.length() {
            Length::Seconds(seconds) if teachers > 0 => {
                let each = SHARE * seconds / f64::from(teachers);
                (Length::Seconds((1.0 - SHARE) * seconds), Length::Seconds(each))
            }
            length => (length, length),
        }
    }

    /// How many teachers, refused where photographs or settings rule them out and they were asked
    /// for.
    pub(super) fn checked_teachers(
        &self,
        dataset: &Dataset,
        config: &TrainConfig,
    ) -> Result<u32, Failure> {
        let expected = if dataset.has_alpha {
            Some("photographs without alpha")
        } else if config.refine_poses {
            Some("no --refine-poses")
        } else if config.field.kind().n_levels() == 0 {
            Some("--method hash-grid or planes")
        } else {
            None
        };
        self.unless(expected, self.n_teachers(dataset))
    }

    /// The same, once it is known whether photographs are evened out.
    pub(super) fn teachers_of_even(&self, teachers: u32, is_uneven: bool) -> Result<u32, Failure> {
        let expected = "photographs of one exposure; give --exposure off to take them as they are";
        self.unless(is_uneven.then_some(expected), teachers)
    }

    /// So many teachers, unless something else was expected.
    fn unless(&self, expected: Option<&str>, teachers: u32) -> Result<u32, Failure> {
        match (expected, self.scene.teachers) {
            (Some(expected), Some(1..)) => Err(format!("--teachers: expected {expected}").into()),
            (Some(_), _) => Ok(0),
            (None, _) => Ok(teachers),
        }
    }

    /// What the teachers show is added to what is learnt from.
    pub(super) fn taught(
        &self,
        prepared: Prepared,
        n: u32,
        (level, stop): (SimdLevel, &Stop),
        bar: &mut Bar,
    ) -> Result<Prepared, Failure> {
        if n == 0 {
            return Ok(prepared);
        }
        bar.say(&format!(
            "{n} fields are trained first, and the model learns from what they show between the \
             photographs, too; --teachers 0 leaves them out"
        ));
        let (_, each) = self.lengths(n);
        let mut at = 0;
        let taught = prepared.taught((n, each), level, &mut |number, progress| {
            if number != at {
                at = number;
                bar.phase("training a teacher");
            }
            bar.show(progress);
            !stop.is_asked()
        })?;
        match taught {
            Some(taught) => Ok(taught),
            None => Err(Interrupted.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_train::builtin;
    use pocketnerf_train::dataset::Split;

    use super::*;
    use crate::commands::train::options::tests::train;

    #[test]
    fn long_runs_of_few_forward_facing_photographs_have_teachers() {
        let teachers = |options: &[&str], change: &dyn Fn(&mut Dataset)| {
            let mut dataset = builtin::dataset(Split::Train, 16);
            dataset.views.truncate(31);
            (dataset.has_alpha, dataset.forward_facing) = (false, true);
            change(&mut dataset);
            train(options).n_teachers(&dataset)
        };
        assert_eq!(teachers(&["--seconds", "480"], &|_| {}), 2);
        assert_eq!(teachers(&["--steps", "20000"], &|_| {}), 2);
        assert_eq!(teachers(&["--steps", "20000", "--teachers", "0"], &|_| {}), 0);
        assert_eq!(teachers(&["--teachers", "3"], &|_| {}), 3);
        for short in [["--seconds", "479"], ["--steps", "19999"]] {
            assert_eq!(teachers(&short, &|_| {}), 0);
        }
        let long = ["--seconds", "600"];
        let add = |dataset: &mut Dataset| dataset.views.push(dataset.views[0].clone());
        assert_eq!(teachers(&long, &add), 0);
        assert_eq!(teachers(&long, &|dataset| dataset.has_alpha = true), 0);
        assert_eq!(teachers(&long, &|dataset| dataset.forward_facing = false), 0);
        assert_eq!(teachers(&["--steps", "20000", "--refine-poses"], &|_| {}), 0);
    }

    #[test]
    fn time_is_shared_and_steps_are_not() {
        let timed = train(&["--seconds", "100"]);
        assert_eq!(timed.lengths(2), (Length::Seconds(40.0), Length::Seconds(30.0)));
        assert_eq!(timed.lengths(0), (Length::Seconds(100.0), Length::Seconds(100.0)));
        let steps = Length::Steps(7);
        assert_eq!(train(&["--steps", "7"]).lengths(2), (steps, steps));
    }
}
