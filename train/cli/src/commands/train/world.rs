//! Options about the coordinates of a dataset.

use pocketnerf_formats::World;

use crate::commands::parse::parse_direction;

/// What the model file stores about the dataset's coordinates.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(in crate::commands) struct WorldOptions {
    /// Up direction in the dataset's coordinates: x, y, z, -x, -y, -z or three numbers [default: as
    /// the dataset or the model says, else z]
    ///
    /// Viewers turn about it, and it becomes +y in .glb files.
    #[arg(long, value_name = "AXIS", value_parser = parse_direction, allow_hyphen_values = true)]
    pub(in crate::commands) up: Option<[f32; 3]>,
    /// Metres per unit of the dataset's coordinates [default: as the dataset or the model says]
    ///
    /// .glb files are in metres. Everything else is in the dataset's units.
    #[arg(long, value_name = "METRES", value_parser = parse_metres)]
    pub(in crate::commands) scale: Option<f32>,
}

impl WorldOptions {
    /// These options where they are given, else what is known already.
    pub(in crate::commands) fn or(self, known: World) -> World {
        World { up: self.up.or(known.up), metres: self.scale.or(known.metres) }
    }

    /// Whether anything is said.
    pub(in crate::commands) fn is_given(self) -> bool {
        self.up.is_some() || self.scale.is_some()
    }
}

pub(in crate::commands) fn parse_metres(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|metres| (1e-6..=1e6).contains(metres));
    metres.ok_or_else(|| "expected metres, from 1e-6 to 1e6".to_owned())
}
