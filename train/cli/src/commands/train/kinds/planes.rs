//! Options of `pocketnerf train --method planes`.

use pocketnerf_train::field::{PlanesConfig, PlanesFieldConfig};
use pocketnerf_train::trainer::{Length, TrainConfig};

#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "With --method planes")]
pub(super) struct PlanesOptions {
    /// Entries along an axis of a plane in the end, from 16 to 1024 [default: as many as
    /// photographs have pixels across, 32 to 300]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1024))]
    plane_resolution: Option<u32>,
    /// Products of a plane and a line along each axis: 16 or 32 [default: 16]
    #[arg(long, value_name = "N", value_parser = parse_components)]
    components: Option<u32>,
}

fn parse_components(text: &str) -> Result<u32, String> {
    let components = text.parse().ok().filter(|n| [16, 32].contains(n));
    components.ok_or_else(|| "expected 16 or 32".to_owned())
}

impl PlanesOptions {
    /// An option that was given, to refuse it without its method.
    pub(super) fn given(&self) -> Option<&'static str> {
        let given = [
            ("--plane-resolution", self.plane_resolution.is_some()),
            ("--components", self.components.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// What to say of planes that are far coarser than photographs of so many pixels across: with a
    /// sixth of the usual entries along an axis 3.0 dB are lost, with a third 1.0 (the still life at
    /// 100x100, 3,000 steps), or 2.1 (1,100 steps).
    pub(super) fn doubt(&self, pixels: f32) -> Option<String> {
        const FEWER: u32 = 3;
        let usual = PlanesConfig::resolution_for(pixels);
        let given = self.plane_resolution.filter(|given| FEWER * given < usual)?;
        Some(format!(
            "--plane-resolution {given}: expected about {usual} entries for photographs of {pixels:.0} \
             pixels across: details are missing"
        ))
    }

    /// The settings of a new run.
    pub(super) fn config(&self, pixels: f32, length: Length) -> TrainConfig {
        let usual = PlanesFieldConfig::default();
        let grid = PlanesConfig::new(
            self.plane_resolution.unwrap_or_else(|| PlanesConfig::resolution_for(pixels)),
            self.components.unwrap_or(usual.grid.n_components),
        );
        TrainConfig::new(PlanesFieldConfig { grid, ..usual }).for_length(length)
    }
}
