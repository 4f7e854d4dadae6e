//! What captures of photographs have in common: folders of smaller images, and a world
//! whose scale and axes mean nothing.

mod folders;
mod found;
mod world;

pub(super) use folders::{Images, choose};
pub(super) use found::with_images;
pub(super) use world::World;
