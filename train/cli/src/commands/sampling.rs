//! `--sampling`.

use clap::ValueEnum;
use pocketnerf_train::picture;

/// Where the samples of a ray lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Sampling {
    /// Equal steps through occupied cells, until almost no light passes
    #[default]
    Occupancy,
    /// A fixed number of samples per ray: stratified, then where these have weight
    Hierarchical,
}

impl From<Sampling> for picture::Sampling {
    fn from(sampling: Sampling) -> Self {
        match sampling {
            Sampling::Occupancy => Self::Occupancy,
            Sampling::Hierarchical => Self::Paper,
        }
    }
}
