//! How many steps a run has, and what each is like.

use std::time::Instant;

use crate::trainer::run::LONG_ENOUGH;
use crate::trainer::{StepSettings, TrainConfig};

/// How long to train.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// So many steps: repeatable to the bit.
    Steps(u32),
    /// Until this long after the start of the program, the model written. The
    /// number of steps follows from a short calibration, and is adjusted to the
    /// clock from time to time.
    Seconds(f64),
}

impl Length {
    /// Steps a second of the machine that settings are chosen for.
    pub(crate) const PACE: f64 = 110.0;

    /// Its steps, on a machine that takes 110 a second.
    #[must_use]
    pub fn about_steps(self) -> f64 {
        match self {
            Self::Steps(steps) => steps.into(),
            Self::Seconds(seconds) => Self::PACE * seconds,
        }
    }
}

/// The steps over which learning rates fall and everything else that changes
/// with time does: from `first` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The first step.
    pub first: u32,
    /// The step at which the run is over.
    pub end: u32,
}

impl Plan {
    /// How much of the plan has been done before `step`, 0 to 1.
    pub(crate) fn progress(&self, step: u32) -> f32 {
        let steps = self.end.saturating_sub(self.first).max(1);
        step.saturating_sub(self.first) as f32 / steps as f32
    }
}

/// Time kept for packing and writing the model, seconds.
const WRITING: f64 = 0.4;
/// Time kept for trying it out, as long as nobody knows how long that takes, seconds.
const FINISHING: f64 = 1.8;
/// Progress from which on it can be known.
pub(crate) const KNOWN: f32 = 0.5;
/// Share of the time that calibrates the number of steps.
const CALIBRATION: f64 = 0.1;
/// So many times as long for steps that take long.
const PATIENT: f64 = 1.5;
/// Share of the remaining time after which the plan is adjusted.
const ADJUSTMENT: f64 = 0.05;
/// Share of the remaining time that the plan uses.
const MARGIN: f64 = 0.99;
/// The occupancy stays as it is for this last share of the run, so that the
/// field ends trained on the cells that are stored.
const FREEZE: f32 = 0.9;
/// Steps over which the learning rate rises. Fewer are not worth a new attempt.
pub(crate) const WARM_UP: u32 = 100;
/// From here on parameters are averaged: what is left of the noise of single
/// steps cancels.
pub(crate) const AVERAGED: f32 = 0.75;
/// Steps between two that count in the average.
const AVERAGE_EVERY: u32 = 8;
/// Decay of a step at most, times the learning rate.
const MOST_DECAY: f32 = 0.1;
/// Runs of more steps than this forget more, in proportion to the root of their number.
const LONG: f32 = 7000.0;
/// So many times more at most.
const MOST_LONGER: f32 = 2.0;
/// From here on colours between the training views are held to what these see. From the start
/// on, highlights would not become as sharp as they are; short runs have none.
const HELD: f32 = 0.7;
/// Runs of more steps than this, and of four times as many, let rays go through more than a pixel's
/// centre, and through all of it.
const SPREAD: f32 = 8000.0;
/// Long steps are taken for this first share of the run.
const COARSE: f32 = 0.6;

/// Seconds of a run of so many that are left for steps, where finishing the model takes
/// `finishing`, if that is known.
pub(crate) fn budget(seconds: f64, finishing: Option<f64>) -> f64 {
    (seconds - WRITING - finishing.unwrap_or(FINISHING)).max(0.5 * seconds)
}

/// Fixes the number of steps once enough have been timed: `timed` since `begun`.
pub(crate) fn calibrate(begun: Instant, deadline: Instant, timed: u32, step: u32) -> Option<Plan> {
    let spent = begun.elapsed().as_secs_f64();
    let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
    let enough = if timed < 32 { PATIENT } else { 1.0 };
    if spent < enough * CALIBRATION * (spent + left) {
        return None;
    }
    let steps = left * MARGIN / (spent / f64::from(timed));
    Some(Plan { first: step, end: step.saturating_add(steps as u32) })
}

/// Fits a plan to the clock again: steps take longer or shorter as the scene
/// takes shape, and the machine may have other things to do. Progress goes on
/// from where it is. `None` while too few steps have been timed.
pub(crate) fn adjust(
    plan: Plan,
    begun: Instant,
    deadline: Instant,
    timed: u32,
    step: u32,
) -> Option<Plan> {
    let spent = begun.elapsed().as_secs_f64();
    let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
    if timed < 32 || spent < ADJUSTMENT * (spent + left) {
        return None;
    }
    let steps = left * MARGIN / (spent / f64::from(timed));
    let progress = f64::from(plan.progress(step)).min(0.999);
    let behind = steps * progress / (1.0 - progress);
    let first = step.saturating_sub(behind as u32);
    Some(Plan { first, end: step.saturating_add((steps as u32).max(1)) })
}

/// The schedule: learning rates fall exponentially, the roulette keeps more
/// and steps shorten as the field sharpens. Entries decay by as much over a minute as
/// over a second, by twice as much over five minutes: there is more that training
/// views alone made up. Not before the plan is known.
pub(crate) fn settings(config: &TrainConfig, step: u32, plan: Option<Plan>) -> StepSettings {
    let progress = plan.map_or(0.0, |plan| plan.progress(step));
    let steps = plan.map_or(f32::INFINITY, |plan| plan.end.saturating_sub(plan.first) as f32);
    let longer = (steps / LONG).sqrt().clamp(1.0, MOST_LONGER);
    let warm = ((step + 1) as f32 / WARM_UP as f32).min(1.0);
    let [first, last] = config.kept;
    if config.hierarchical_training().is_some() {
        return StepSettings {
            rate: config.final_rate.powf(progress),
            step_scale: 1.0,
            decay: 0.0,
            smoothing: 0.0,
            kept: 1.0,
            update_occupancy: false,
            average: false,
            between_views: false,
            spread: 0.0,
            progress,
        };
    }
    StepSettings {
        rate: warm * config.final_rate.powf(progress),
        step_scale: if progress < COARSE { config.first_step_scale } else { 1.0 },
        decay: (config.grid_decay * longer / steps).min(MOST_DECAY),
        smoothing: config.field.kind().training().grid_smoothing / steps,
        kept: first * (last / first).powf(progress),
        update_occupancy: progress < FREEZE,
        average: progress >= AVERAGED && step.is_multiple_of(AVERAGE_EVERY),
        between_views: progress >= HELD && steps >= LONG_ENOUGH as f32,
        spread: plan.map_or(0.0, |_| spread(steps)),
        progress,
    }
}

/// Width of what rays of a pixel go through in a run of so many steps: the longer photographs are
/// learnt, the more of what only one of them shows.
fn spread(steps: f32) -> f32 {
    (0.5 * (steps / SPREAD).log2()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longer_runs_go_through_more_of_a_pixel() {
        let spread = |first, end| {
            let plan = Some(Plan { first, end });
            settings(&TrainConfig::hash_grid(), first, plan).spread
        };
        let found = [(0, 3000), (0, 8000), (100, 16_100), (0, 32_000), (0, 90_000)]
            .map(|(first, end)| spread(first, end));
        assert_eq!(found, [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(settings(&TrainConfig::hash_grid(), 0, None).spread, 0.0, "not yet known");
    }
}
