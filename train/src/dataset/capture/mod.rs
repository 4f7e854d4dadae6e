//! What captures of photographs have in common: folders of smaller images, and a world
//! whose scale and axes mean nothing.

mod around;
mod folders;
mod found;
mod own;
mod ply;
mod world;

pub(super) use around::{Around, FEWEST, WRONG, around, at, reach, surround};
pub(super) use folders::{Images, choose};
pub(super) use found::{unmasked, with_images};
pub use own::Own;
pub(super) use ply::points;
pub(super) use world::World;
