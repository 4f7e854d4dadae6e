//! Stops a run that has gone wrong.
//!
//! Every step is checked. Where values are not finite, or nothing has been learnt after
//! [`PATIENCE`] steps, training restarts with other random numbers, at most
//! [`MAX_RESTARTS`] times. Checks depend on the steps alone, not on threads or clocks: the
//! same run restarts at the same step.

use std::fmt;

use crate::random::Random;
use crate::trainer::{StepStats, Targets, Trainer};

/// Attempts after the first; then training gives up.
pub const MAX_RESTARTS: u32 = 3;
/// Steps of an attempt before its pictures are judged.
pub(crate) const PATIENCE: u32 = 512;
/// Steps between two checks of the tables, which are large; the loss and all other
/// parameters are checked after every step.
const TABLES_EVERY: u32 = 64;
/// Opacity (or transparency) below which there is none.
const NONE: f64 = 1e-3;
/// Opacity (or transparency) of the images from which its lack is a fault.
const SOME: f64 = 1e-2;
/// A field that has learnt something is below this share of the trivial error ...
const LEARNT: f64 = 0.95;
/// ... or below this mean squared error (30 dB): images may be of one colour.
const GOOD: f64 = 1e-3;
/// Weight of the newest step in the averages: they reach back about fifty steps.
const NEWEST: f64 = 0.02;

/// Why an attempt was given up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// The loss or a parameter is infinite or not a number.
    NotFinite,
    /// Nothing is left of the scene.
    Vanished {
        /// Mean opacity of the rays.
        opacity: f64,
        /// Mean alpha of the images.
        alpha: f64,
    },
    /// Fog fills the scene: no ray comes through.
    Fog {
        /// Mean opacity of the rays.
        opacity: f64,
        /// Mean alpha of the images.
        alpha: f64,
    },
    /// The background alone, or one colour everywhere, would do as well.
    NothingLearnt {
        /// PSNR of the latest rays, dB.
        psnr: f64,
        /// PSNR of the better of the two, dB.
        trivial: f64,
    },
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "the loss or a parameter is not a finite number"),
            Self::Vanished { opacity, alpha } => {
                write!(f, "the scene has vanished (opacity {opacity:.4}, images {alpha:.4})")
            }
            Self::Fog { opacity, alpha } => {
                write!(f, "fog fills the scene (opacity {opacity:.4}, images {alpha:.4})")
            }
            Self::NothingLearnt { psnr, trivial } => write!(
                f,
                "nothing has been learnt (PSNR {psnr:.2} dB, one colour gives {trivial:.2} dB)"
            ),
        }
    }
}

/// Training was given up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "training failed at step {step} after {restarts} restarts, of at most {MAX_RESTARTS}: \
     {trouble}; expected a scene that the cameras see inside its box: check images and cameras \
     with `pocketnerf info`, give --aabb, more --seconds or another --seed"
)]
pub struct Diverged {
    /// What was wrong with the last attempt.
    pub trouble: Trouble,
    /// The step at which it was noticed.
    pub step: u32,
    /// How often training had restarted.
    pub restarts: u32,
}

/// Moving averages over the latest steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Averages {
    /// Mean squared error over rays and colours.
    pub(crate) squared_error: f64,
    /// Opacity of the rays.
    pub(crate) opacity: f64,
}

impl Averages {
    pub(crate) fn add(&mut self, stats: &StepStats) {
        let follow = |average: &mut f64, new: f64| {
            *average = if *average == 0.0 { new } else { *average + NEWEST * (new - *average) };
        };
        follow(&mut self.squared_error, stats.mean_squared_error);
        follow(&mut self.opacity, stats.mean_opacity);
    }

    /// dB; 0 before the first step.
    pub(crate) fn psnr(&self) -> f64 {
        if self.squared_error == 0.0 { 0.0 } else { psnr(self.squared_error) }
    }
}

fn psnr(squared_error: f64) -> f64 {
    -10.0 * squared_error.max(1e-12).log10()
}

/// Looks at a trainer after a step that gave `stats`.
pub(crate) fn look(trainer: &Trainer, stats: &StepStats, averages: &Averages) -> Option<Trouble> {
    let tables = trainer.step.is_multiple_of(TABLES_EVERY);
    if !stats.mean_squared_error.is_finite() || !is_finite(trainer, tables) {
        return Some(Trouble::NotFinite);
    }
    if trainer.step < PATIENCE { None } else { judge(&trainer.targets, averages) }
}

/// Whether what has been learnt looks like the images at all.
pub(super) fn judge(targets: &Targets, averages: &Averages) -> Option<Trouble> {
    let (opacity, alpha) = (averages.opacity, targets.alpha);
    let missing = |found: f64, wanted: f64| found < NONE && wanted > SOME;
    if missing(opacity, alpha) {
        Some(Trouble::Vanished { opacity, alpha })
    } else if missing(1.0 - opacity, 1.0 - alpha) {
        Some(Trouble::Fog { opacity, alpha })
    } else if averages.squared_error > (LEARNT * targets.trivial_error).max(GOOD) {
        let trivial = psnr(targets.trivial_error);
        Some(Trouble::NothingLearnt { psnr: averages.psnr(), trivial })
    } else {
        None
    }
}

/// Whether all parameters are finite; with or without the tables.
pub(crate) fn is_finite(trainer: &Trainer, tables: bool) -> bool {
    trainer.backend.is_finite(tables)
}

/// Where the random numbers of the `restarts`-th attempt after the first begin.
pub(crate) fn seed(seed: u64, restarts: u32) -> u64 {
    match restarts {
        0 => seed,
        n => Random::new(seed, [3, u64::from(n), 0]).next_u64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGETS: Targets =
        Targets { alpha: 0.3, trivial_error: 0.05, unseen_error: 0.0, unseen_share: 0.0 };

    fn trouble(targets: Targets, opacity: f64, squared_error: f64) -> Option<Trouble> {
        judge(&targets, &Averages { squared_error, opacity })
    }

    #[test]
    fn a_scene_like_its_images_is_left_alone() {
        assert_eq!(trouble(TARGETS, 0.3, 0.01), None);
        // Images of an empty or a full scene: its lack is no fault.
        assert_eq!(trouble(Targets { alpha: 0.005, ..TARGETS }, 0.0, 0.01), None);
        assert_eq!(trouble(Targets { alpha: 1.0, ..TARGETS }, 1.0, 0.01), None);
        // Images of one colour: nothing beats the trivial, and nothing need.
        assert_eq!(
            trouble(
                Targets { alpha: 1.0, trivial_error: 0.0, unseen_error: 0.0, unseen_share: 0.0 },
                1.0,
                5e-4
            ),
            None
        );
    }

    #[test]
    fn each_trouble_is_told_from_the_others() {
        use Trouble::{Fog, NothingLearnt, Vanished};
        assert!(matches!(trouble(TARGETS, 1e-4, 0.01), Some(Vanished { .. })));
        assert!(matches!(trouble(TARGETS, 0.9999, 0.01), Some(Fog { .. })));
        let nothing = trouble(TARGETS, 0.3, 0.05);
        assert!(matches!(nothing, Some(NothingLearnt { .. })));
        assert_eq!(
            nothing.unwrap().to_string(),
            "nothing has been learnt (PSNR 13.01 dB, one colour gives 13.01 dB)"
        );
    }

    #[test]
    fn attempts_have_seeds_of_their_own() {
        assert_eq!(seed(7, 0), 7);
        let seeds = [seed(7, 0), seed(7, 1), seed(7, 2), seed(7, 3), seed(8, 1)];
        for (i, a) in seeds.iter().enumerate() {
            assert!(seeds[..i].iter().all(|b| a != b));
        }
    }
}
