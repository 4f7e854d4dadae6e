//! A whole run, from the first step to the last.

pub mod checkpoint;
mod error;
pub(crate) mod guard;
mod report;
pub(crate) mod size;
#[cfg(test)]
mod tests;
pub(crate) mod watch;

use std::time::{Duration, Instant};

use crate::compact;
use crate::trainer::optim::schedule::{KNOWN, WARM_UP, adjust, budget, calibrate, settings};
use crate::trainer::{FinishingBudget, HeldOutPsnr, Length, Plan, StepStats, Trainer};
pub use error::{NoTime, RunError};
use guard::{Averages, Diverged, MAX_RESTARTS, Trouble};
pub use report::{Progress, Summary};
use size::Size;
use watch::{Overfitted, Then, Watch};

/// Shorter runs learn from all views from the first step on, and what they risk between these is
/// not measured.
pub(crate) const LONG_ENOUGH: u32 = 1024;

/// A run, taken step by step, so that the caller may save or stop between two.
#[derive(Clone, Debug)]
pub struct Run {
    pub(crate) length: Length,
    pub(crate) plan: Option<Plan>,
    pub(crate) averages: Averages,
    pub(crate) watch: Watch,
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
    /// How large the model file is to be.
    size: Size,
    /// Longer sides of the pictures that are compared to find its size.
    side: u32,
    /// Seconds that finding it takes, at the end, if that is known.
    sizing: Option<f64>,
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
            watch: Watch::default(),
            rays: 0,
            samples: 0,
            before,
            started,
            timed: None,
            by_clock,
            finishing: None,
            size: Size::Whole,
            side: compact::SIDE,
            sizing: None,
        }
    }

    /// Takes a step; `None` where the run is over.
    ///
    /// # Errors
    /// When the guard has given up, or when the time is over before the first step.
    pub fn step(&mut self, trainer: &mut Trainer) -> Result<Option<Progress>, RunError> {
        let mut trouble = None;
        if self.is_over(trainer) {
            self.add(&trainer.wait());
            if let (Length::Seconds(seconds), 0) = (self.length, trainer.steps()) {
                return Err(NoTime { seconds, before: self.elapsed() }.into());
            }
            // The last look: the guard does not see every parameter at every step.
            if guard::is_finite(trainer, true) {
                trainer.finish();
                if let Some(found) = trainer.look_at_held_out() {
                    self.watch.note_end(found);
                }
                return Ok(None);
            }
            trouble = Some(Trouble::NotFinite);
            self.restart(trainer, Trouble::NotFinite)?;
        }
        if trainer.steps() == 0 {
            self.hold_out(trainer);
        }
        self.plan_the_end(trainer);
        self.plan_sizing(trainer);
        self.round_for_bytes(trainer);
        if let Some(plan) = self.plan() {
            trainer.clear_fog(plan.progress(trainer.steps()), self.averages.psnr());
        }
        let (begun, steps) = self.fit_to_clock((trainer.steps(), trainer.config().settled()));
        let stats = trainer.step(&settings(trainer.config(), trainer.steps(), self.plan()));
        self.timed = Some((begun, steps + 1));
        self.add(&stats);
        if let Some(found) = guard::look(trainer, &stats, &self.averages) {
            trouble = Some(found);
            self.restart(trainer, found)?;
        }
        self.look(trainer);
        Ok(Some(Progress {
            step: trainer.steps(),
            steps: self.plan().map(|plan| plan.end),
            train_psnr: self.averages.psnr(),
            held_out_psnr: self.watch.last().map(|found| found.mean),
            restarts: trainer.restarts(),
            trouble,
        }))
    }

    /// Counts what a step found out, if anything.
    fn add(&mut self, stats: &StepStats) {
        if stats.rays > 0 {
            self.averages.add(stats);
            self.rays = self.rays.saturating_add(stats.rays as u64);
            self.samples = self.samples.saturating_add(stats.samples as u64);
        }
    }

    /// Whether all steps are taken, or the time is over.
    #[must_use]
    pub fn is_over(&self, trainer: &Trainer) -> bool {
        self.plan().is_some_and(|plan| trainer.steps() >= plan.end) || self.is_late()
    }

    /// The steps, as far as they are known.
    fn plan(&self) -> Option<Plan> {
        self.watch.ending().or(self.plan)
    }

    /// Holds a few views out, where the run is long enough to return them. Hierarchical
    /// sampling is as in the paper: all views, from first to last.
    fn hold_out(&mut self, trainer: &mut Trainer) {
        let short = matches!(self.length, Length::Steps(n) if n < LONG_ENOUGH);
        let to_the_end = self.watch.to_the_end;
        // The pose of a photograph that is not learnt from would stay as wrong as it is.
        let config = trainer.config();
        let can = config.hierarchical_training().is_none() && !config.refine_poses;
        if (!short || to_the_end) && can {
            self.watch = Watch::new(trainer.hold_out() > 0);
            self.watch.to_the_end = to_the_end;
        }
    }

    /// Looks at the held-out views, where it is time.
    fn look(&mut self, trainer: &mut Trainer) {
        let step = trainer.steps();
        let Some(plan) = self.plan.filter(|plan| self.watch.is_due(*plan, step)) else { return };
        let settled = step >= trainer.config().settled();
        let then = match trainer.look_at_held_out() {
            Some(found) => self.watch.note(found, (plan, step), settled),
            // What cannot be looked at is of no use.
            None => self.watch.end(),
        };
        match then {
            Then::GoOn => {}
            Then::Remember => trainer.remember(),
            Then::GoBack => trainer.go_back(),
            Then::Return => trainer.return_views(),
        }
    }

    /// PSNR of the held-out views when they were last looked at: before they came back, or, in
    /// a run that overfits, at the end. `None` where none were held out.
    #[must_use]
    pub fn held_out_psnr(&self) -> Option<HeldOutPsnr> {
        self.watch.last()
    }

    /// Whether the run was ended early because it overfits.
    #[must_use]
    pub fn overfitted(&self) -> Option<Overfitted> {
        self.watch.overfitted()
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
        let left = budget - self.before - self.sizing.unwrap_or(0.0);
        Some(self.started + Duration::from_secs_f64(left.max(0.0)))
    }

    /// Fits the plan to the clock, once enough steps have been timed. Gives when those that are
    /// being timed began, and how many they are. A field is `settled` after so many steps.
    fn fit_to_clock(&mut self, (step, settled): (u32, u32)) -> (Instant, u32) {
        let (begun, timed) = *self.timed.get_or_insert_with(|| (Instant::now(), 0));
        let (Some(deadline), None) = (self.deadline(), self.watch.ending()) else {
            return (begun, timed);
        };
        let fitted = match self.plan {
            None => calibrate(begun, deadline, timed, step),
            Some(plan) => adjust(plan, begun, deadline, timed, step),
        };
        let Some(plan) = fitted else { return (begun, timed) };
        if plan.end < settled && self.finishing.is_none() {
            // Its model will not be calibrated, which leaves more time for steps.
            self.finishing = Some((FinishingBudget::NONE, 0.0));
            return self.fit_to_clock((step, settled));
        }
        self.plan = fitted;
        (Instant::now(), 0)
    }

    /// Once the scene has taken shape: measures how long calibration will take, so
    /// that there is time for it.
    fn plan_the_end(&mut self, trainer: &Trainer) {
        let (Length::Seconds(seconds), true, None) = (self.length, self.by_clock, self.finishing)
        else {
            return;
        };
        if self.plan.is_some_and(|plan| plan.progress(trainer.steps()) >= KNOWN) {
            let nothing = (FinishingBudget::NONE, 0.0);
            let settled = trainer.config().settled() as f32;
            self.finishing = Some(match trainer.steps() as f32 >= KNOWN * settled {
                true => trainer
                    .rehearse()
                    .map_or(nothing, |costs| costs.budget(seconds, trainer.is_on_gpu())),
                false => nothing,
            });
            self.timed = None;
        }
    }

    /// How much the finished model is to be calibrated.
    #[must_use]
    pub fn finishing_budget(&self, trainer: &Trainer) -> FinishingBudget {
        match self.finishing {
            _ if trainer.steps() < trainer.config().settled() => FinishingBudget::NONE,
            Some((budget, _)) => budget,
            None => FinishingBudget::usual(trainer.config(), trainer.steps()),
        }
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

    /// What is wrong with what a short run has learnt. Longer runs end with an error instead.
    #[must_use]
    pub fn doubt(&self, trainer: &Trainer) -> Option<Trouble> {
        guard::judge(&trainer.targets, &self.averages)
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
/// As [`Run::step`].
pub fn run(
    trainer: &mut Trainer,
    length: Length,
    started: Instant,
    mut report: impl FnMut(Progress),
) -> Result<Summary, RunError> {
    let mut run = Run::new(length, started);
    while let Some(progress) = run.step(trainer)? {
        report(progress);
    }
    Ok(run.summary(trainer))
}
