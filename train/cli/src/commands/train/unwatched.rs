//! Training without the cargo feature `view`: nobody watches.

use std::path::Path;

use pocketnerf_train::trainer::{Run, Trainer};

use super::{Bar, Origin};
use crate::commands::{Common, Failure, view};

#[derive(Clone, Debug, clap::Args)]
pub(in crate::commands) struct WatchOptions {
    /// Where the scene would be watched.
    #[arg(long, hide = true, num_args = 0..=1, require_equals = true, default_missing_value = "")]
    view: Option<String>,
}

impl WatchOptions {
    /// Whether somebody is to watch.
    pub(super) fn is_asked(&self) -> bool {
        self.view.is_some()
    }

    /// Trains, unless a window is asked for.
    pub(super) fn attend(
        &self,
        _: &Path,
        train: impl FnOnce(Audience) -> Result<(), Failure> + Send,
    ) -> Result<(), Failure> {
        match self.view {
            Some(_) => Err(view::refusal("--view").into()),
            None => train(Audience),
        }
    }
}

/// Nobody.
pub(super) struct Audience;

impl Audience {
    pub(super) fn bar(&self, common: &Common) -> Bar {
        Bar::new(common)
    }

    pub(super) fn after_step(&mut self, _: &Trainer, _: &Run, _: &Origin, _: &Bar) {}

    pub(super) fn finish(&self, _: &Path) {}

    pub(super) fn stays(&self) -> bool {
        false
    }
}
