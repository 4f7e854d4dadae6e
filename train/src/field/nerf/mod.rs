//! The paper's field, trainable: its shape, and the way back through it.
//!
//! Forwards it is core's kernels, layer by layer, with every layer's output kept
//! ([`Tape`]); backwards, two products a layer ([`NerfGradients`]).

mod backward;
mod config;
mod tape;
#[cfg(test)]
mod tests;
mod weights;

pub(crate) use backward::slope;
pub use backward::{NerfGradients, NerfWork};
pub use config::{FourierConfig, NerfConfig, NerfLayer, NerfPart, WavesConfig};
pub use tape::Tape;
