//! When the prepass gives up: a run of a few seconds has no time for a scene that takes longer
//! to find.

use std::time::Instant;

use pocketnerf_core::Error;

/// Why there is no prepared run.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepassError {
    /// The configuration does not make a valid field, or the SIMD level is not there.
    #[error(transparent)]
    Field(#[from] Error),
    /// The time was over before the scene was found.
    #[error("the time was over before the scene was found; expected more time")]
    OutOfTime,
}

/// When the prepass must have ended, if ever.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deadline(Option<Instant>);

impl Deadline {
    /// There is all the time that it takes.
    pub const NONE: Self = Self(None);

    /// Until then.
    #[must_use]
    pub const fn at(end: Instant) -> Self {
        Self(Some(end))
    }

    /// Whether it is over.
    pub(super) fn has_passed(self) -> bool {
        self.0.is_some_and(|end| Instant::now() >= end)
    }

    /// Fails where it is over.
    pub(super) fn check(self) -> Result<(), PrepassError> {
        if self.has_passed() { Err(PrepassError::OutOfTime) } else { Ok(()) }
    }
}
