//! Trainable fields: their parameters in one flat buffer, and their gradients.
//!
//! A folder a kind. Whatever is above this module sees a [`TrainableField`]; the one match
//! over kinds is in `config`.

mod config;
pub mod hash_grid;
mod layout;
pub mod nerf;
mod network;
mod rounded;
pub mod rounding;
mod trainable;

pub use config::{FieldConfig, FieldKind, Unusable, networks};
pub use hash_grid::HashGridFieldConfig;
pub use layout::{Layout, Part, Range, Role};
pub use nerf::{FourierConfig, NerfConfig, WavesConfig};
pub use rounded::Rounded;
pub use trainable::{
    BATCH, Back, Context, HIERARCHICAL_RAYS, HierarchicalTraining, Network, STRIDE,
    SampleGradients, Tape, TrainableField, Update,
};

use trainable::sum_groups;
