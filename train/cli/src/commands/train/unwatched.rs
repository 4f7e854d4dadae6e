//! Training without the cargo feature `view`: nobody watches.

use std::path::Path;

use pocketnerf_train::trainer::{Run, Trainer};

use super::{Bar, Origin};
use crate::commands::Failure;

#[derive(Clone, Debug, clap::Args)]
pub(in crate::commands) struct WatchOptions {}

impl WatchOptions {
    /// Trains.
    #[allow(clippy::unused_self, reason = "with the feature it has options")]
    pub(super) fn attend(
        &self,
        _: &Path,
        train: impl FnOnce(Audience) -> Result<(), Failure> + Send,
    ) -> Result<(), Failure> {
        train(Audience)
    }
}

/// Nobody.
pub(super) struct Audience;

impl Audience {
    pub(super) fn bar(&self, quiet: bool) -> Bar {
        Bar::new(quiet)
    }

    pub(super) fn after_step(&mut self, _: &Trainer, _: &Run, _: &Origin, _: &Bar) {}

    pub(super) fn finish(&self, _: &Path) {}

    pub(super) fn stays(&self) -> bool {
        false
    }
}
