//! Trainable fields: their parameters in one flat buffer, and their gradients.
//!
//! Nothing above this module knows the kind of a field: the optimizer, the
//! checkpoint and the model file see named ranges of one `f32` buffer. The
//! forward pass is core's, on a view of that buffer.

mod backward;
mod config;
mod hash_grid;
mod init;
mod layout;
mod nerf;
mod network;
mod rounded;
pub mod rounding;

pub use backward::{Backward, Gradients};
pub use config::{EncodingConfig, FieldConfig};
pub use hash_grid::scatter_level;
pub use init::initialize;
pub use layout::{Layout, Part, Range};
pub(crate) use nerf::slope;
pub use nerf::{FourierConfig, NerfConfig, NerfLayer, NerfPart, WavesConfig};
#[doc(hidden)]
pub use nerf::{NerfGradients, NerfWork, Tape};
pub use rounded::Rounded;
