//! The one match over kinds of fields.

use std::fmt::Debug;

use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::{AnyField, Error};

use super::hash_grid::HashGridFieldConfig;
use super::nerf::{self, NerfConfig, NetworksReport};
use super::{HierarchicalTraining, Layout, TrainableField};

/// The kind of a trainable field, and its shape.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldConfig {
    /// A multiresolution hash grid and two small networks.
    HashGrid(HashGridFieldConfig),
    /// A deep network over encoded positions (vanilla NeRF).
    Nerf(NerfConfig),
}

impl FieldConfig {
    /// What there is to know of the kind.
    #[must_use]
    pub fn kind(&self) -> &dyn FieldKind {
        match self {
            Self::HashGrid(config) => config,
            Self::Nerf(config) => config,
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
            _ => Err(Unusable::Model("a kind of field unknown to this build")),
        }
    }

    /// The hash grid, where it is one.
    pub const fn hash_grid_mut(&mut self) -> Option<&mut HashGridFieldConfig> {
        match self {
            Self::HashGrid(config) => Some(config),
            Self::Nerf(_) => None,
        }
    }

    /// The vanilla NeRF, where it is one.
    pub const fn nerf_mut(&mut self) -> Option<&mut NerfConfig> {
        match self {
            Self::HashGrid(_) => None,
            Self::Nerf(config) => Some(config),
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

/// What is known of a kind of field before there are parameters.
pub trait FieldKind: Debug {
    /// A field of this shape, whose densities are per `1 / scale` scene units.
    fn build(&self, scale: f32) -> Box<dyn TrainableField>;

    /// Where each tensor lies among the parameters.
    fn layout(&self) -> Layout;

    /// A small field that learns the outline of the same scene in a second.
    fn coarse(&self) -> FieldConfig;

    /// Checks that there can be such a field.
    ///
    /// # Errors
    /// What core's validation reports of an encoding.
    fn validate(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Whether a sample takes a thousand times as long as one of a hash grid.
    fn is_costly(&self) -> bool {
        false
    }

    /// How it is trained by hierarchical sampling, where it is.
    fn hierarchical_training(&self) -> Option<HierarchicalTraining> {
        None
    }

    /// Numbers of samples for rendering by hierarchical sampling, where its models have them.
    fn hierarchical_sampling(&self) -> Option<Hierarchical> {
        None
    }

    /// What a checkpoint holds beside the model, where the kind has such a section.
    fn section(&self) -> Option<Vec<u8>> {
        None
    }
}

impl HierarchicalTraining {
    /// 64 + 128 samples, no noise, no crop.
    pub const PLAIN: Self = Self {
        sampling: Hierarchical { reach: Reach::Clipped, ..Hierarchical::PAPER },
        noise: 0.0,
        crop_steps: 0,
    };
}

/// Why a field cannot be trained on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// The model is not one that training makes.
    Model(&'static str),
    /// What a checkpoint adds is missing.
    NoSection,
    /// What a checkpoint adds is damaged.
    Section,
}
