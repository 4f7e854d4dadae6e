//! The built-in scenes: ray-traced, with exact pixels and depth.
//!
//! They need no download. The still life is made to be hard in several ways at once: a stone
//! whose grain is as fine as the pixels, wires one pixel wide, a glaze whose reflections
//! slide over it, a white vase on the white background. Each of the others ([`Scene`]) shows
//! one thing at which radiance fields fail.
//!
//! Scene units; z points up. Rendering uses +, −, ×, ÷, square root and integers only, so
//! the pixels have the same bits on every platform.

mod cameras;
mod contents;
mod medium;
mod noise;
mod render;
mod scene;
mod scenes;
mod shading;
mod shapes;
mod sky;
#[cfg(test)]
mod spectrum;
mod surface;
#[cfg(test)]
mod tests;
mod tile;

use crate::dataset::{Dataset, Split};
pub use scene::Scene;

/// Width and height of a full-size view in pixels.
pub const SIZE: u32 = 400;
/// Views of [`Split::Train`].
pub const TRAIN_VIEWS: usize = 60;
/// Views of [`Split::Val`] and [`Split::Test`].
pub const HELD_OUT_VIEWS: usize = 12;

/// The views of one split of the still life: [`Scene::dataset`] of [`Scene::StillLife`].
///
/// [`Split::Val`] and [`Split::Test`] are the same held-out views, each halfway
/// between two training views: there is nothing to overfit settings to beyond
/// the scene itself, which is frozen.
#[must_use]
pub fn dataset(split: Split, downscale_factor: u32) -> Dataset {
    Scene::StillLife.dataset(split, downscale_factor)
}

/// FNV-1a over the bits of all cameras, pixels and depths, view after view.
#[must_use]
pub fn content_hash(dataset: &Dataset) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut feed = |bytes: &[u8]| {
        for &byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    };
    for view in &dataset.views {
        let camera = &view.camera;
        feed(&camera.width.to_le_bytes());
        feed(&camera.height.to_le_bytes());
        for number in camera.focal.iter().chain(&camera.center).chain(&camera.camera_to_world) {
            feed(&number.to_le_bytes());
        }
        feed(&view.rgba);
        for depth in view.depth.iter().flatten() {
            feed(&depth.to_le_bytes());
        }
    }
    hash
}
