//! Why a run ends without a model.

use super::guard::Diverged;

/// A run ended without a model.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The guard has given up.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// The time was over before the first step.
    #[error(transparent)]
    NoTime(#[from] NoTime),
}

/// The time of a run was over before its first step.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "--seconds {seconds}: reading the images and finding the scene takes {before:.1} s, which \
     leaves no time to train; expected at least {}: give --seconds {0}, --downscale-factor or --views",
    self.least()
)]
pub struct NoTime {
    /// What the run was given.
    pub seconds: f64,
    /// What it takes until the first step.
    pub before: f64,
}

impl NoTime {
    /// Twice what it takes to begin, whole seconds.
    #[must_use]
    pub fn least(&self) -> f64 {
        (2.0 * self.before).ceil().max(self.seconds + 1.0)
    }
}
