//! Options of `pocketnerf train --method plenoxels`.

use pocketnerf_train::field::PlenoxelsConfig;
use pocketnerf_train::trainer::TrainConfig;

#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "With --method plenoxels")]
pub(super) struct PlenoxelOptions {
    /// Voxels along the longest side of the scene in the end: a multiple of 4, from 16 to 512
    /// [default: 256]
    #[arg(long, value_name = "N", value_parser = parse_voxels)]
    voxels: Option<u32>,
    /// Bands of spherical harmonics: 1 (no view dependence), 2 or 3 [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3))]
    sh_bands: Option<u32>,
}

fn parse_voxels(text: &str) -> Result<u32, String> {
    let voxels = text.parse().ok().filter(|n| (16..=512).contains(n) && n % 4 == 0);
    voxels.ok_or_else(|| "expected a multiple of 4 from 16 to 512".to_owned())
}

impl PlenoxelOptions {
    /// An option that was given, to refuse it without its method.
    pub(super) fn given(&self) -> Option<&'static str> {
        let given = [("--voxels", self.voxels.is_some()), ("--sh-bands", self.sh_bands.is_some())];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// The settings of a new run.
    pub(super) fn config(&self) -> TrainConfig {
        let usual = PlenoxelsConfig::default();
        let voxels = self.voxels.unwrap_or(usual.last_resolution);
        TrainConfig::new(PlenoxelsConfig::new(voxels, self.sh_bands.unwrap_or(usual.sh_degree)))
    }
}
