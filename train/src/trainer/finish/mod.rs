//! What becomes of a trained field: a model to be rendered.

pub(crate) mod budget;
mod bytes;
pub(crate) mod calibration_tiles;
pub(crate) mod color_jumps;
mod finished;
pub(crate) mod photos;
pub(crate) mod pruning;
pub(crate) mod tolerance;
mod unseen;

pub use finished::Finished;
