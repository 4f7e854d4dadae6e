//! What `pocketnerf convert` knows beside the library: configs of other programs, files that
//! are not converted, and views to distil from.

pub mod config;
pub mod distill;
mod kind;
pub mod nerfstudio;
mod verify;

pub use kind::{instead, refuse_others};
pub use verify::{Difference, compare, compare_models};
