//! The built-in scene: a ray-traced still life with exact depth.
//!
//! It needs no download, and it is made to be hard where radiance fields are
//! weak: a stone whose grain is as fine as the pixels, wires one pixel wide, a
//! glaze whose reflections slide over it, a white vase on the white background.
//!
//! Scene units; z points up; everything lies within 1.25 units of the origin
//! in x and y. Rendering uses +, −, ×, ÷, square root and integers only, so the
//! pixels have the same bits on every platform.

mod cameras;
mod noise;
mod render;
mod scene;
mod shading;
mod shapes;
#[cfg(test)]
mod spectrum;
mod surface;
#[cfg(test)]
mod tests;

use crate::dataset::{Dataset, Split, View};

/// Width and height of a full-size view in pixels.
pub const SIZE: u32 = 400;
/// Views of [`Split::Train`].
pub const TRAIN_VIEWS: usize = 60;
/// Views of [`Split::Val`] and [`Split::Test`].
pub const HELD_OUT_VIEWS: usize = 12;

/// The views of one split, rendered at [`SIZE`] divided by `downscale_factor`.
///
/// [`Split::Val`] and [`Split::Test`] are the same held-out views, each halfway
/// between two training views: there is nothing to overfit settings to beyond
/// the scene itself, which is frozen.
///
/// Pixels are straight RGBA on a transparent background, alpha is coverage.
/// Depth is the distance along the ray through the pixel's centre, so a pixel
/// at an outline may be partly covered and still have infinite depth.
#[must_use]
pub fn dataset(split: Split, downscale_factor: u32) -> Dataset {
    let (cameras, prefix) = match split {
        Split::Train => (cameras::train(), "train"),
        Split::Val | Split::Test => (cameras::held_out(), "held_out"),
    };
    let bodies = scene::bodies();
    let views = cameras
        .iter()
        .enumerate()
        .map(|(i, camera)| {
            let camera = camera.downscaled(downscale_factor.max(1));
            let (rgba, depth) = render::view(&bodies, &camera);
            let view = View::new(format!("{prefix}/{i:02}"), camera, rgba);
            View { depth: Some(depth), ..view }
        })
        .collect();
    Dataset::new("built-in scene", "built-in", split, views)
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
