//! Options of `pocketnerf train --method derf`.

use pocketnerf_train::field::DerfConfig;
use pocketnerf_train::trainer::TrainConfig;

use super::nerf::NerfOptions;

#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "With --method derf")]
pub(super) struct DerfOptions {
    /// Parts of the scene, 1 to 64, each with a network of --depth 4 and --width 64 [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    heads: Option<u32>,
}

impl DerfOptions {
    /// An option that was given, to refuse it without its method.
    pub(super) fn given(&self) -> Option<&'static str> {
        self.heads.map(|_| "--heads")
    }

    /// The settings of a new run, with heads as a vanilla NeRF's options say.
    pub(super) fn config(&self, nerf: &NerfOptions) -> TrainConfig {
        let mut derf = DerfConfig::default();
        derf.n_heads = self.heads.map_or(derf.n_heads, |n| n as usize);
        nerf.shape(&mut derf.head);
        TrainConfig::new(derf)
    }
}
