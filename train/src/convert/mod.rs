//! Models of other programs' checkpoints.
//!
//! `pocketnerf_formats::import` reads the fields of checkpoints. What else rendering needs,
//! [`Settings`] hold; which cells are occupied is what the program kept, or is baked from the
//! density.

mod bake;
mod error;
mod nerf;
mod ngp;
mod settings;
mod volume;

use pocketnerf_core::{Camera, Model};
use pocketnerf_formats::{PixelOrigin, Scene};

pub use error::ConvertError;
pub use nerf::{NerfConversion, Place};
pub use ngp::NgpConversion;
pub use settings::Settings;
pub use volume::{VolumeConversion, VolumePainter};

use crate::picture::Sampling;

/// A model made of another program's checkpoint.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one of them")]
pub enum Conversion {
    /// The networks of vanilla NeRF.
    Nerf(NerfConversion),
    /// A hash grid.
    Ngp(NgpConversion),
}

impl Conversion {
    /// The model, in f32.
    ///
    /// # Errors
    /// What core refuses.
    pub fn model(&self) -> Result<Model<'_>, ConvertError> {
        match self {
            Self::Nerf(source) => source.model(),
            Self::Ngp(source) => source.model(),
        }
    }

    /// The program that wrote the checkpoint.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        match self {
            Self::Nerf(source) => source.program(),
            Self::Ngp(source) => source.program(),
        }
    }

    /// How the source places samples.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        match self {
            Self::Nerf(_) => Sampling::Hierarchical,
            Self::Ngp(_) => Sampling::Occupancy,
        }
    }

    /// Where the source's rays passed through pixels.
    #[must_use]
    pub const fn pixel_origin(&self) -> PixelOrigin {
        match self {
            Self::Nerf(source) => source.pixel_origin(),
            Self::Ngp(_) => PixelOrigin::Center,
        }
    }

    /// From the model's coordinates to those of the dataset.
    #[must_use]
    pub fn scene(&self) -> Scene<'static> {
        match self {
            Self::Nerf(_) => Scene::default(),
            Self::Ngp(source) => source.scene(),
        }
    }

    /// The cameras of its training views, scene units, if the checkpoint has them.
    #[must_use]
    pub fn views(&self) -> &[Camera] {
        match self {
            Self::Nerf(_) => &[],
            Self::Ngp(source) => source.views(),
        }
    }

    /// The distance of the source's cameras from what they look at, scene units; 0 if
    /// unknown.
    #[must_use]
    pub const fn distance(&self) -> f32 {
        match self {
            Self::Nerf(source) => source.distance(),
            Self::Ngp(_) => 0.0,
        }
    }
}
