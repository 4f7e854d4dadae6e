//! A whole run: how many steps there are, and what each is like.

use std::time::{Duration, Instant};

use super::{StepSettings, StepStats, TrainConfig, Trainer};

/// How long to train.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// So many steps: repeatable to the bit.
    Steps(u32),
    /// Until this long after the start of the program. The number of steps is
    /// fixed after a short calibration.
    Seconds(f64),
}

/// Share of the time that calibrates the number of steps.
const CALIBRATION: f64 = 0.1;
/// Share of the remaining time that the plan uses.
const MARGIN: f64 = 0.97;
/// The occupancy stays as it is for this last share of the run, so that the
/// field ends trained on the cells that are stored.
const FREEZE: f32 = 0.9;
/// Steps over which the learning rate rises.
const WARM_UP: f32 = 100.0;
/// Long steps are taken for this first share of the run.
const COARSE: f32 = 0.3;

/// Where a run stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps taken.
    pub step: u32,
    /// Steps in all; `None` until they are known.
    pub steps: Option<u32>,
    /// PSNR of the latest rays, dB.
    pub train_psnr: f64,
}

/// What a run did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    /// Rays cast.
    pub rays: u64,
    /// Samples at which the field was asked.
    pub samples: u64,
    /// PSNR of the last rays against random backgrounds or the images' own, dB.
    pub train_psnr: f64,
}

/// Trains to the end. `started` is when the program began.
pub fn run(
    trainer: &mut Trainer,
    length: Length,
    started: Instant,
    mut report: impl FnMut(Progress),
) -> Summary {
    let begun = Instant::now();
    let mut plan = match length {
        Length::Steps(n) => Some((0, n)),
        Length::Seconds(_) => None,
    };
    let deadline = match length {
        Length::Steps(_) => None,
        Length::Seconds(s) => Some(started + Duration::from_secs_f64(s)),
    };
    let mut summary = Summary::default();
    let mut error = 0.0;
    loop {
        let step = trainer.steps();
        if plan.is_some_and(|(_, end)| step >= end) || deadline.is_some_and(|d| Instant::now() >= d)
        {
            return summary;
        }
        if let (None, Some(deadline)) = (plan, deadline) {
            plan = calibrate(begun, deadline, step);
        }
        let progress =
            plan.map_or(0.0, |(first, end)| (step - first) as f32 / (end - first).max(1) as f32);
        let stats = trainer.step(&settings(trainer.config(), step, progress));
        add(&mut summary, &mut error, &stats);
        report(Progress {
            step: step + 1,
            steps: plan.map(|(_, end)| end),
            train_psnr: summary.train_psnr,
        });
    }
}

/// Fixes the number of steps once enough have been timed.
fn calibrate(begun: Instant, deadline: Instant, step: u32) -> Option<(u32, u32)> {
    let spent = begun.elapsed().as_secs_f64();
    let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
    if step < 32 || spent < CALIBRATION * (spent + left) {
        return None;
    }
    let steps = left * MARGIN / (spent / f64::from(step));
    Some((step, step + steps as u32))
}

/// The schedule: learning rates fall exponentially, the roulette keeps more
/// and steps shorten as the field sharpens.
fn settings(config: &TrainConfig, step: u32, progress: f32) -> StepSettings {
    let warm = ((step + 1) as f32 / WARM_UP).min(1.0);
    let [first, last] = config.kept;
    StepSettings {
        rate: warm * config.final_rate.powf(progress),
        step_scale: if progress < COARSE { config.first_step_scale } else { 1.0 },
        kept: first * (last / first).powf(progress),
        update_occupancy: progress < FREEZE,
    }
}

/// A moving average over about fifty steps.
fn add(summary: &mut Summary, error: &mut f64, stats: &StepStats) {
    summary.rays += stats.rays as u64;
    summary.samples += stats.samples as u64;
    *error = if *error == 0.0 {
        stats.mean_squared_error
    } else {
        *error + 0.02 * (stats.mean_squared_error - *error)
    };
    summary.train_psnr = -10.0 * error.max(1e-12).log10();
}
