//! Options of commands that read datasets.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{self, Dataset, DatasetError, LoadOptions, Split};
use pocketnerf_train::trainer::NoTime;

use super::{Common, Failure, memory};

/// Names the still life, in place of a folder; with a colon and a name, any built-in scene.
pub(super) const BUILT_IN: &str = "builtin";

/// Share of a run's time that may pass with reading images.
const SHARE: f64 = 0.5;

/// How to read a dataset.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Dataset")]
pub(super) struct Reading {
    /// Hold out every N-th image, by name, for val and test, if the dataset has no splits;
    /// 0: train on all
    #[arg(long, value_name = "N", default_value_t = LoadOptions::default().hold_every)]
    pub(super) hold_every: u32,
    /// Treat an LLFF capture as an inward-facing 360-degree capture
    #[arg(long)]
    pub(super) spherify: bool,
}

impl Reading {
    /// The library's options.
    pub(super) fn options(self, downscale_factor: u32) -> LoadOptions {
        let Self { hold_every, spherify } = self;
        let memory = memory::free();
        LoadOptions { downscale_factor, hold_every, spherify, deadline: None, memory }
    }

    /// As [`read`](Self::read), within so many seconds from `started` on.
    pub(super) fn read_within(
        self,
        (started, seconds): (Instant, f64),
        folder: &Path,
        split: Split,
        downscale_factor: u32,
    ) -> Result<Dataset, Failure> {
        let within = Duration::from_secs_f64(SHARE * seconds);
        let options =
            LoadOptions { deadline: started.checked_add(within), ..self.options(downscale_factor) };
        read(folder, split, &options).map_err(|error| match error {
            DatasetError::OutOfTime { read, total, .. } => {
                let before = started.elapsed().as_secs_f64() * total as f64 / read.max(1) as f64;
                NoTime { seconds, before }.into()
            }
            error => error.into(),
        })
    }

    /// Reads a split of the dataset in `folder`, or of a built-in scene if that is its
    /// [name](BUILT_IN) and there is no such folder.
    pub(super) fn read(
        self,
        folder: &Path,
        split: Split,
        downscale_factor: u32,
    ) -> Result<Dataset, DatasetError> {
        read(folder, split, &self.options(downscale_factor))
    }

    /// Reads a split and prints what the user should know.
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

    /// These options, as on a command line.
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

/// As [`Reading::read`], with the library's options.
pub(super) fn read(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Dataset, DatasetError> {
    if let Some(found) = held(folder, split, options.downscale_factor) {
        return found;
    }
    match built_in(folder)? {
        Some(scene) => Ok(scene.dataset(split, options.downscale_factor)),
        None => dataset::load_with(folder, split, options),
    }
}

/// Datasets in memory, by number; each has some splits.
static HELD: Mutex<Vec<(u64, Arc<Vec<Dataset>>)>> = Mutex::new(Vec::new());

/// A dataset in memory, which commands read in place of a folder as long as this lives.
#[derive(Debug)]
pub struct HeldDataset(u64);

/// Holds a dataset in memory: its splits, of which training needs one.
#[must_use]
pub fn hold(splits: Arc<Vec<Dataset>>) -> HeldDataset {
    static LAST: AtomicU64 = AtomicU64::new(0);
    let number = LAST.fetch_add(1, Ordering::Relaxed);
    HELD.lock().unwrap_or_else(PoisonError::into_inner).push((number, splits));
    HeldDataset(number)
}

/// Names a dataset in memory, behind this and a colon by its number.
const MEMORY: &str = "memory";

impl HeldDataset {
    /// What stands for a folder in the arguments of a command.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        format!("{MEMORY}:{}", self.0).into()
    }
}

impl Drop for HeldDataset {
    fn drop(&mut self) {
        let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
        held.retain(|(number, _)| *number != self.0);
    }
}

/// The split of a dataset in memory; `None` if the folder is not the name of one.
fn held(folder: &Path, split: Split, factor: u32) -> Option<Result<Dataset, DatasetError>> {
    let number: u64 = folder.to_str()?.strip_prefix(MEMORY)?.strip_prefix(':')?.parse().ok()?;
    let splits = {
        let held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(&held.iter().find(|(held, _)| *held == number)?.1)
    };
    let found = splits.iter().find(|dataset| dataset.split == split).cloned();
    let missing = || {
        let has: Vec<&str> = splits.iter().map(|dataset| dataset.split.name()).collect();
        let file = splits.first().map_or(folder.into(), |dataset| dataset.source.clone().into());
        let why = format!("it has {}; say which images are for {split}", has.join(", "));
        DatasetError::EmptySplit { file, split: split.name(), why }
    };
    Some(found.ok_or_else(missing).and_then(|dataset| dataset.downscaled(factor)))
}

/// The built-in scene of this name, unless it names a folder.
fn built_in(folder: &Path) -> Result<Option<Scene>, DatasetError> {
    let name = folder.to_str().and_then(|text| text.strip_prefix(BUILT_IN));
    let Some(name) = name.filter(|_| !folder.exists()) else { return Ok(None) };
    if name.is_empty() {
        return Ok(Some(Scene::StillLife));
    }
    let Some(name) = name.strip_prefix(':') else { return Ok(None) };
    match Scene::named(name) {
        Some(scene) => Ok(Some(scene)),
        None => {
            let scenes = Scene::ALL.map(|scene| format!("{BUILT_IN}:{}", scene.name())).join(", ");
            Err(DatasetError::NoSuchScene { path: folder.to_owned(), scenes })
        }
    }
}

/// The folder's name, without characters that a file name may not have.
pub(super) fn scene_name(data: &Path) -> String {
    let whole = data.canonicalize().unwrap_or_else(|_| data.to_owned());
    let name = whole.file_name().map_or_else(String::new, |name| name.display().to_string());
    let fits = |c: char| if c.is_alphanumeric() || "-._".contains(c) { c } else { '_' };
    name.chars().map(fits).collect()
}
