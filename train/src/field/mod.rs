//! Trainable fields: their parameters in one flat buffer, and their gradients.
//!
//! A folder a kind. Whatever is above this module sees a [`TrainableField`]; a new kind is a
//! module here and a variant of [`FieldConfig`].

pub mod derf;
mod encoded;
pub(crate) mod harmonics;
pub mod hash_grid;
mod kind;
mod layout;
mod logistic;
pub mod nerf;
mod network;
pub mod planes;
pub mod plenoxels;
mod rounded;
pub mod rounding;
#[cfg(test)]
mod testing;
mod trainable;

pub use derf::DerfConfig;
pub use encoded::{EncodedFieldConfig, Encoding};
pub use hash_grid::HashGridFieldConfig;
pub use kind::{FieldKind, Grown, Training, Unusable};
pub use layout::{Layout, Part, Range, Role};
pub use nerf::{FourierConfig, NerfConfig, NetworksReport, WavesConfig};
pub use planes::{PlanesConfig, PlanesFieldConfig};
pub use plenoxels::PlenoxelsConfig;
pub use rounded::Rounded;
pub use trainable::{
    BATCH, Back, Context, HIERARCHICAL_RAYS, HierarchicalTraining, Network, STRIDE,
    SampleGradients, Tape, TrainableField, Update,
};

use pocketnerf_core::AnyField;
use trainable::sum_groups;

/// The kind of a trainable field, and its shape: the one match over kinds.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldConfig {
    /// A multiresolution hash grid and two small networks.
    HashGrid(HashGridFieldConfig),
    /// A deep network over encoded positions (vanilla NeRF).
    Nerf(NerfConfig),
    /// A sparse grid of voxels without networks (Plenoxels).
    Plenoxels(PlenoxelsConfig),
    /// Planes and lines and two small networks (as in TensoRF).
    Planes(PlanesFieldConfig),
    /// Small networks for parts of a scene (as in DeRF).
    Derf(DerfConfig),
}

impl FieldConfig {
    /// What there is to know of the kind.
    #[must_use]
    pub fn kind(&self) -> &dyn FieldKind {
        match self {
            Self::HashGrid(config) => config,
            Self::Nerf(config) => config,
            Self::Plenoxels(config) => config,
            Self::Planes(config) => config,
            Self::Derf(config) => config,
        }
    }

    /// The shape of a model's field, with what a checkpoint adds to it.
    ///
    /// # Errors
    /// Why it cannot be trained.
    pub fn of(field: &AnyField<'_>, section: Option<&[u8]>) -> Result<Self, Unusable> {
        match field {
            AnyField::HashGrid(field) => Ok(Self::HashGrid(HashGridFieldConfig::of(field))),
            AnyField::Nerf(field) => NerfConfig::restored(field, section).map(Self::Nerf),
            AnyField::Plenoxels(field) => {
                PlenoxelsConfig::restored(field, section).map(Self::Plenoxels)
            }
            AnyField::Derf(field) => DerfConfig::restored(field, section).map(Self::Derf),
            AnyField::Planes(field) => {
                PlanesFieldConfig::restored(field, section).map(Self::Planes)
            }
            _ => Err(Unusable::Model("a kind of field unknown to this build")),
        }
    }

    /// The hash grid, where it is one.
    pub const fn hash_grid_mut(&mut self) -> Option<&mut HashGridFieldConfig> {
        if let Self::HashGrid(config) = self { Some(config) } else { None }
    }

    /// Widths of the hidden layers of the density network and of the colour network, where these
    /// stand behind an encoding.
    pub const fn hidden_mut(&mut self) -> Option<[&mut Vec<usize>; 2]> {
        match self {
            Self::HashGrid(config) => Some([&mut config.density_hidden, &mut config.color_hidden]),
            Self::Planes(config) => Some([&mut config.density_hidden, &mut config.color_hidden]),
            _ => None,
        }
    }
}

/// Describes the networks of a field; `None` for kinds whose networks stand behind a grid.
#[must_use]
pub fn networks(field: &AnyField<'_>) -> Option<NetworksReport> {
    match field {
        AnyField::Nerf(field) => Some(nerf::report(field)),
        _ => None,
    }
}
