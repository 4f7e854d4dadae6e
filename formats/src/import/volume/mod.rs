//! Volumes that other programs trained and that no kind of field here holds: they are rendered as
//! those programs render them, for another field to learn from the pictures.
//!
//! * [`TensoRf`]: `torch.save`d models of apchenstu/TensoRF, VM and CP;
//! * [`Svox2`]: `.npz` checkpoints of sxyu/svox2, the Plenoxels of its paper.

mod factors;
mod svox2;
mod tensorf;

pub use factors::Factors;
pub use svox2::Svox2;
pub use tensorf::{AlphaMask, Shading, TensoRf};
