//! A whole run, from the first step to the last.

pub mod checkpoint;
pub(crate) mod guard;

use std::time::{Duration, Instant};

use crate::trainer::optim::schedule::{KNOWN, WARM_UP, adjust, budget, calibrate, settings};
use crate::trainer::{FinishingBudget, Length, Plan, Trainer};
use guard::{Averages, Diverged, MAX_RESTARTS, Trouble};

/// Where a run stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps taken.
    pub step: u32,
    /// Steps in all; `None` until they are known.
    pub steps: Option<u32>,
    /// PSNR of the latest rays, dB; 0 before an attempt's first step.
    pub train_psnr: f64,
    /// How often training has restarted.
    pub restarts: u32,
    /// Why it has just restarted.
    pub trouble: Option<Trouble>,
}

/// What a run did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    /// Rays cast, those of attempts that were given up among them.
    pub rays: u64,
    /// Samples at which the field was evaluated.
    pub samples: u64,
    /// PSNR of the last rays against random backgrounds or the images' own, dB.
    pub train_psnr: f64,
    /// How often training restarted.
    pub restarts: u32,
}

/// A run, taken step by step, so that the caller may save or stop between two.
#[derive(Clone, Debug)]
pub struct Run {
    pub(crate) length: Length,
    pub(crate) plan: Option<Plan>,
    pub(crate) averages: Averages,
    pub(crate) rays: u64,
    pub(crate) samples: u64,
    /// Seconds that earlier parts of the run took.
    before: f64,
    /// When the program began.
    started: Instant,
    /// When the steps that are being timed began, and how many there were.
    timed: Option<(Instant, u32)>,
    /// Whether the clock decides when it is over.
    by_clock: bool,
    /// The finishing budget and its seconds; `None` before it is known.
    finishing: Option<(FinishingBudget, f64)>,
}

impl Run {
    /// A run from its beginning. `started` is when the program began.
    #[must_use]
    pub fn new(length: Length, started: Instant) -> Self {
        let plan = match length {
            Length::Steps(end) => Some(Plan { first: 0, end }),
            Length::Seconds(_) => None,
        };
        Self::continued(length, plan, 0.0, started)
    }

    /// A run of which earlier parts took `before` seconds. A plan that is
    /// known is kept to its end, whatever the clock says.
    pub(crate) fn continued(
        length: Length,
        plan: Option<Plan>,
        before: f64,
        started: Instant,
    ) -> Self {
        let by_clock = matches!((length, plan), (Length::Seconds(_), None));
        let averages = Averages::default();
        Self {
            length,
            plan,
            averages,
            rays: 0,
            samples: 0,
            before,
            started,
            timed: None,
            by_clock,
            finishing: None,
        }
    }

    /// Takes a step; `None` where the run is over.
    ///
    /// # Errors
    /// When the guard has given up.
    pub fn step(&mut self, trainer: &mut Trainer) -> Result<Option<Progress>, Diverged> {
        let mut trouble = None;
        if self.is_over(trainer) {
            // The last look: the guard does not see every parameter at every step.
            if guard::is_finite(trainer, true) {
                trainer.finish();
                return Ok(None);
            }
            trouble = Some(Trouble::NotFinite);
            self.restart(trainer, Trouble::NotFinite)?;
        }
        self.plan_the_end(trainer);
        let (mut begun, mut steps) = *self.timed.get_or_insert_with(|| (Instant::now(), 0));
        if let Some(deadline) = self.deadline() {
            let step = trainer.steps();
            let fitted = match self.plan {
                None => calibrate(begun, deadline, steps, step),
                Some(plan) => adjust(plan, begun, deadline, steps, step),
            };
            if fitted.is_some() {
                self.plan = fitted;
                (begun, steps) = (Instant::now(), 0);
            }
        }
        let stats = trainer.step(&settings(trainer.config(), trainer.steps(), self.plan));
        self.timed = Some((begun, steps + 1));
        self.averages.add(&stats);
        self.rays = self.rays.saturating_add(stats.rays as u64);
        self.samples = self.samples.saturating_add(stats.samples as u64);
        if let Some(found) = guard::look(trainer, &stats, &self.averages) {
            trouble = Some(found);
            self.restart(trainer, found)?;
        }
        Ok(Some(Progress {
            step: trainer.steps(),
            steps: self.plan.map(|plan| plan.end),
            train_psnr: self.averages.psnr(),
            restarts: trainer.restarts(),
            trouble,
        }))
    }

    /// Whether all steps are taken, or the time is over.
    #[must_use]
    pub fn is_over(&self, trainer: &Trainer) -> bool {
        self.plan.is_some_and(|plan| trainer.steps() >= plan.end) || self.is_late()
    }

    fn is_late(&self) -> bool {
        self.deadline().is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// When the last step must have ended.
    fn deadline(&self) -> Option<Instant> {
        let (Length::Seconds(seconds), true) = (self.length, self.by_clock) else {
            return None;
        };
        let budget = budget(seconds, self.finishing.map(|(_, seconds)| seconds));
        Some(self.started + Duration::from_secs_f64((budget - self.before).max(0.0)))
    }

    /// Once the scene has taken shape: measures how long calibration will take, so
    /// that there is time for it.
    fn plan_the_end(&mut self, trainer: &Trainer) {
        let (Length::Seconds(seconds), true, None) = (self.length, self.by_clock, self.finishing)
        else {
            return;
        };
        if self.plan.is_some_and(|plan| plan.progress(trainer.steps()) >= KNOWN) {
            self.finishing = trainer.rehearse().ok().map(|costs| costs.budget(seconds));
            self.timed = None;
        }
    }

    /// How much the finished model is to be calibrated.
    #[must_use]
    pub fn finishing_budget(&self, trainer: &Trainer) -> FinishingBudget {
        self.finishing
            .map_or_else(|| FinishingBudget::usual(trainer.config()), |(budget, _)| budget)
    }

    /// Restarts: with all steps in a run of so many steps, with those that are left in a
    /// run of so many seconds.
    fn restart(&mut self, trainer: &mut Trainer, trouble: Trouble) -> Result<(), Diverged> {
        let (step, restarts) = (trainer.steps(), trainer.restarts());
        let mut plan = self.plan;
        let mut hopeless = restarts >= MAX_RESTARTS;
        if let Length::Seconds(_) = self.length {
            plan = plan.map(|plan| Plan { first: 0, end: plan.end.saturating_sub(step) });
            hopeless |= plan.is_some_and(|plan| plan.end < WARM_UP) || self.is_late();
        }
        if hopeless {
            return Err(Diverged { trouble, step, restarts });
        }
        self.plan = plan;
        self.averages = Averages::default();
        trainer.begin(restarts + 1);
        Ok(())
    }

    /// What has been done so far.
    #[must_use]
    pub fn summary(&self, trainer: &Trainer) -> Summary {
        Summary {
            rays: self.rays,
            samples: self.samples,
            train_psnr: self.averages.psnr(),
            restarts: trainer.restarts(),
        }
    }

    /// Seconds that the run has taken so far, all its parts together.
    #[must_use]
    pub fn elapsed(&self) -> f64 {
        self.before + self.started.elapsed().as_secs_f64()
    }
}

/// Trains to the end. `started` is when the program began.
///
/// # Errors
/// When the guard has given up.
pub fn run(
    trainer: &mut Trainer,
    length: Length,
    started: Instant,
    mut report: impl FnMut(Progress),
) -> Result<Summary, Diverged> {
    let mut run = Run::new(length, started);
    while let Some(progress) = run.step(trainer)? {
        report(progress);
    }
    Ok(run.summary(trainer))
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::TrainConfig;

    fn trainer() -> Trainer {
        let mut config = TrainConfig::hash_grid();
        let grid = &mut config.field.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        config.occupancy_resolution = 16;
        config.samples_per_side = 32.0;
        config.samples_per_step = 512;
        let mut dataset = builtin::dataset(Split::Train, 40);
        dataset.views.truncate(8);
        Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap()
    }

    fn parameters(trainer: &Trainer) -> &[f32] {
        &trainer.backend.download().field().parameters
    }

    /// Steps to the end; `before` may meddle before each.
    fn finish(
        (trainer, run): (&mut Trainer, &mut Run),
        mut before: impl FnMut(&mut Trainer),
    ) -> Vec<Trouble> {
        let mut troubles = Vec::new();
        loop {
            before(trainer);
            match run.step(trainer).unwrap() {
                Some(progress) => troubles.extend(progress.trouble),
                None => return troubles,
            }
        }
    }

    fn steps(n: u32) -> Run {
        Run::new(Length::Steps(n), Instant::now())
    }

    #[test]
    fn a_poisoned_run_recovers() {
        let mut expected = trainer();
        expected.begin(1);
        assert!(finish((&mut expected, &mut steps(40)), |_| ()).is_empty());
        // A network's weight is noticed after a step, anything when all is done.
        let last = parameters(&expected).len() - 1;
        for (step, at) in [(30, last), (40, 0)] {
            let mut poisoned = trainer();
            let mut run = steps(40);
            let troubles = finish((&mut poisoned, &mut run), |trainer| {
                if (trainer.step, trainer.restarts) == (step, 0) {
                    let mut state = trainer.backend.download().clone();
                    state.field_mut().parameters[at] = f32::NAN;
                    trainer.backend.upload(state);
                }
            });
            assert_eq!(troubles, [Trouble::NotFinite]);
            assert_eq!((poisoned.steps(), run.summary(&poisoned).restarts), (40, 1));
            assert!(parameters(&poisoned) == parameters(&expected));
        }
    }

    #[test]
    fn a_timed_run_starts_over_with_what_is_left() {
        let timed = |end| {
            let plan = Some(Plan { first: 50, end });
            let mut run = Run::continued(Length::Seconds(60.0), plan, 1.0, Instant::now());
            let mut trainer = trainer();
            trainer.step = 300;
            let result = run.restart(&mut trainer, Trouble::NotFinite);
            result.map(|()| (run.plan, trainer.steps(), trainer.restarts()))
        };
        assert_eq!(timed(1000), Ok((Some(Plan { first: 0, end: 700 }), 0, 1)));
        assert_eq!(timed(400), Ok((Some(Plan { first: 0, end: 100 }), 0, 1)));
        let diverged = Diverged { trouble: Trouble::NotFinite, step: 300, restarts: 0 };
        assert_eq!(timed(399), Err(diverged));
    }
}
