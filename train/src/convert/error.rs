//! Why a model is not converted, as values.

use std::path::PathBuf;

use pocketnerf_formats::import::{FieldError, ImportError};

/// Why a model is not converted. Each message completes a line that begins with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// The container cannot be read.
    #[error(transparent)]
    Checkpoint(#[from] ImportError),
    /// The tensors are not those of a field that is known.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Another kind of model.
    #[error("{found} are not converted; {hint}")]
    Kind {
        /// What it is, in the plural.
        found: &'static str,
        /// What to do.
        hint: &'static str,
    },
    /// The checkpoint does not say how its pictures are made.
    #[error("neither the checkpoint nor a config beside it says {0}; give these options")]
    Missing(String),
    /// Near and far are not in order.
    #[error("near {near}, far {far}: expected 0 <= near < far")]
    Bounds {
        /// Nearest depth.
        near: f32,
        /// Farthest depth.
        far: f32,
    },
    /// Too few samples, or too many.
    #[error("{n_coarse} and {n_fine} samples: expected 4 to {most} and 0 to {most}")]
    Samples {
        /// Evenly spaced ones.
        n_coarse: u32,
        /// Drawn from their weights.
        n_fine: u32,
        /// The most that are taken.
        most: u32,
    },
    /// Normalised device coordinates need cameras.
    #[error(
        "rays in normalised device coordinates: which ones, the capture's cameras say; give \
         --data with the capture that it was trained on{0}"
    )]
    NoCameras(&'static str),
    /// The box is empty.
    #[error(
        "there is nothing within {0:?} (smallest and largest corner); give the scene's box, \
         --aabb X0,Y0,Z0,X1,Y1,Z1"
    )]
    Empty([[f32; 3]; 2]),
    /// The config says what cannot be done.
    #[error("{}: {problem}", .file.display())]
    Config {
        /// The config file.
        file: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// There is no config where one is needed.
    #[error(
        "{} is not there: it says whether the scene is in a box, which the checkpoint does not",
        .0.display()
    )]
    Beside(PathBuf),
    /// What core refuses.
    #[error(transparent)]
    Core(#[from] pocketnerf_core::Error),
}
