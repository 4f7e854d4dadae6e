//! What training on a dataset costs, by the program's defaults.

use pocketnerf_train::dataset::{DatasetReport, SplitReport};
use pocketnerf_train::trainer::{Length, TrainConfig};
use serde::Serialize;

use crate::commands::memory;
use crate::commands::train::SECONDS;

/// Bytes of memory that a run takes beside the photographs, for each parameter: values, moments,
/// gradients and averages.
const RUN_PER_PARAMETER: f64 = 40.0;
/// The program itself, its threads' memory, cells.
const PROGRAM: f64 = 80e6;
/// Bytes of a model file for each parameter, tables of eight bits, packed: of an object, where much
/// of what there is room for stays empty, and of a place.
const FILE_PER_PARAMETER_OF_OBJECT: f64 = 0.35;
const FILE_PER_PARAMETER: f64 = 0.7;

/// What training costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Cost {
    /// Wall time from start to file, seconds.
    seconds: f64,
    /// Peak of memory, about.
    memory_bytes: u64,
    /// Of the model file, about.
    model_bytes: u64,
}

impl Cost {
    /// Of a run with the defaults on the training split.
    pub(super) fn of(report: &DatasetReport) -> Option<Self> {
        let split = report.splits.iter().find(|split| split.split == "train")?;
        let in_box = !report.forward_facing && !report.has_no_end;
        let is_object = in_box && split.images_with_alpha > 0;
        let config = TrainConfig::usual(is_object, split.pixels_across())
            .for_length(Length::Seconds(SECONDS));
        let parameters = config.field.kind().n_parameters() as f64;
        let per_parameter =
            if is_object { FILE_PER_PARAMETER_OF_OBJECT } else { FILE_PER_PARAMETER };
        let run = PROGRAM + RUN_PER_PARAMETER * parameters;
        Some(Self {
            seconds: SECONDS,
            memory_bytes: run as u64 + images(split, rayon::current_num_threads()),
            model_bytes: (per_parameter * parameters) as u64,
        })
    }

    /// A line that says that there is too little memory.
    pub(super) fn doubt(&self) -> Option<String> {
        let advice = "give --downscale-factor or fewer images";
        let what = || "training with the defaults".to_owned();
        memory::check(self.memory_bytes, advice, what).err().map(|error| error.to_string())
    }

    /// A row of the report.
    pub(super) fn row(&self) -> String {
        format!(
            "cost      by the defaults of `train`: {:.0} minutes, about {:.1} GB of memory, a model \
             of about {:.1} MB",
            self.seconds / 60.0,
            self.memory_bytes as f64 / 1e9,
            self.model_bytes as f64 / 1e6
        )
    }
}

/// Bytes for all images as RGBA, and for those that are decoded at a time.
fn images(split: &SplitReport, threads: usize) -> u64 {
    let pixels = |width: u32, height: u32| u64::from(width) * u64::from(height);
    let sizes = || split.sizes.iter();
    let all: u64 = sizes().map(|s| s.images as u64 * pixels(s.width, s.height)).sum();
    let largest = sizes().map(|s| pixels(s.width, s.height)).max().unwrap_or(0);
    4 * all + 8 * largest * split.images_found.min(threads) as u64
}
