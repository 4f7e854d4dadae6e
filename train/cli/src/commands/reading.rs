//! How datasets are read: options of every command that reads one.

use std::path::Path;

use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{self, Dataset, DatasetError, LoadOptions, Split};

use super::Common;

/// What stands for the built-in scene in place of a folder.
pub(super) const BUILT_IN: &str = "builtin";

/// What the files of a dataset do not say.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct Reading {
    /// Of a dataset without splits of its own, hold out every N-th image, in the order
    /// of the names from the first on, for test and val; 0: all train.
    #[arg(long, value_name = "N", default_value_t = LoadOptions::default().hold_every)]
    pub(super) hold_every: u32,
    /// Treat an LLFF capture as one all around a point, which becomes the origin.
    #[arg(long)]
    pub(super) spherify: bool,
}

impl Reading {
    /// The options of the library.
    pub(super) const fn options(self, downscale_factor: u32) -> LoadOptions {
        let Self { hold_every, spherify } = self;
        LoadOptions { downscale_factor, hold_every, spherify }
    }

    /// Reads a split of the dataset in `folder`, or of the built-in scene where that is
    /// its [name](BUILT_IN) and no folder is called so.
    pub(super) fn read(
        self,
        folder: &Path,
        split: Split,
        downscale_factor: u32,
    ) -> Result<Dataset, DatasetError> {
        if folder == Path::new(BUILT_IN) && !folder.exists() {
            return Ok(builtin::dataset(split, downscale_factor));
        }
        dataset::load_with(folder, split, &self.options(downscale_factor))
    }

    /// Reads a split and says what the user should know.
    pub(super) fn load(
        self,
        folder: &Path,
        split: Split,
        downscale_factor: u32,
        common: &Common,
    ) -> Result<Dataset, DatasetError> {
        let dataset = self.read(folder, split, downscale_factor)?;
        if !common.quiet {
            dataset.notes.iter().for_each(|note| eprintln!("note: {note}"));
        }
        Ok(dataset)
    }

    /// The options that were given, to be given again.
    pub(super) fn given(self) -> String {
        let mut given = String::new();
        if self.hold_every != LoadOptions::default().hold_every {
            given += &format!(" --hold-every {}", self.hold_every);
        }
        if self.spherify {
            given += " --spherify";
        }
        given
    }
}
