//! Models that other programs trained, as models of this one: the paper's networks and
//! hash grids (`pocketnerf_formats::import::nerf` and `ngp` tell which programs).
//!
//! A checkpoint holds a field and little else. What its pictures need besides, [`Settings`]
//! take from the config that lies [beside](config::beside) it or from the user; which cells
//! are empty is what the program kept of them, or is baked from the density.

pub mod config;
pub mod distill;
mod error;
mod kind;
mod nerf;
pub mod nerfstudio;
mod ngp;
mod settings;
mod verify;

use pocketnerf_core::{Camera, Model};
use pocketnerf_formats::{PixelOrigin, Scene};
use pocketnerf_train::picture::Sampling;

pub use error::ConvertError;
pub use kind::{instead, refuse_others};
pub use nerf::{NerfConversion, Place};
pub use ngp::NgpConversion;
pub use settings::Settings;
pub use verify::{Difference, compare};

/// A model, made of what another program trained.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one of them")]
pub enum Conversion {
    /// The paper's networks.
    Nerf(NerfConversion),
    /// A hash grid.
    Ngp(NgpConversion),
}

impl Conversion {
    /// The model as a picture needs it, in f32.
    ///
    /// # Errors
    /// What core refuses.
    pub fn model(&self) -> Result<Model<'_>, ConvertError> {
        match self {
            Self::Nerf(source) => source.model(),
            Self::Ngp(source) => source.model(),
        }
    }

    /// The program that it comes from.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        match self {
            Self::Nerf(source) => source.program(),
            Self::Ngp(source) => source.program(),
        }
    }

    /// How the source itself makes pictures.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        match self {
            Self::Nerf(_) => Sampling::Hierarchical,
            Self::Ngp(_) => Sampling::Occupancy,
        }
    }

    /// Where in a pixel the source's rays went through.
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

    /// The cameras that it was trained from, scene units, where the checkpoint has them.
    #[must_use]
    pub fn views(&self) -> &[Camera] {
        match self {
            Self::Nerf(_) => &[],
            Self::Ngp(source) => source.views(),
        }
    }

    /// The distance between what the source's cameras looked at and them, scene units; 0
    /// where nothing says.
    #[must_use]
    pub const fn distance(&self) -> f32 {
        match self {
            Self::Nerf(source) => source.distance(),
            Self::Ngp(_) => 0.0,
        }
    }
}
