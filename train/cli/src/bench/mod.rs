//! How close every stage of rendering and training comes to what bounds it.
//!
//! [`machine`](crate::machine) measures what the machine can do at best; [`work`] counts
//! what a field computes and reads; [`training`] and [`rendering`] time the stages. Everything is
//! measured in one run, because only ratios within one run mean anything.

pub mod networks;
#[cfg(feature = "gpu")]
pub mod on_gpu;
pub mod rendering;
mod report;
mod stage;
mod table;
pub mod training;
mod update;
pub mod work;

pub use rendering::Rendering;
pub use report::Report;
pub use stage::StageCost;
pub use training::Training;

use pocketnerf_train::trainer::RunError;

/// Why measuring failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// The model or the settings.
    #[error(transparent)]
    Core(#[from] pocketnerf_core::Error),
    /// What comes before training.
    #[error(transparent)]
    Prepass(#[from] pocketnerf_train::trainer::prepass::PrepassError),
    /// Training.
    #[error(transparent)]
    Training(#[from] RunError),
    /// The networks' model cannot be written.
    #[error(transparent)]
    Write(#[from] pocketnerf_formats::WriteError),
    /// Nor read.
    #[error(transparent)]
    Read(#[from] pocketnerf_formats::FormatError),
    /// The device does not train.
    #[error("{0}; leave --device out to measure the CPU")]
    Device(String),
    /// Threads cannot be started.
    #[error("no thread can be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
