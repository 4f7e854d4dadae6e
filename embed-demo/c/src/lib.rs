//! pocketnerf for C and C++: open a `.pnerf` file, render it, ask it questions.
//!
//! The header `include/pocketnerf.h` is generated from this crate, with its comments.
//! Rust programs use `pocketnerf-core` and `pocketnerf-formats` instead.
//!
//! Every function checks its arguments as far as possible: null, alignment, lengths, codes and
//! numbers. An error is a [`Status`] and a line of text; outputs are then unchanged. No panic
//! leaves the library, which has no global state, starts no threads and prints nothing. All
//! functions share one safety condition: the caller's pointers are valid, and nobody else writes
//! to the memory during a call.
//!
//! # Example
//! The calls of a C program, in Rust: a picture of a file's own view.
//! ```
//! use std::ptr::{null, null_mut};
//!
//! use pocketnerf_c::*;
//!
//! let bytes = include_bytes!("../../still-life.pnerf");
//! let mut model = null_mut();
//! // SAFETY: all pointers are those of variables here.
//! unsafe {
//!     let opened = pnrf_open_bytes(bytes.as_ptr().cast(), bytes.len(), OPEN_BORROWED, &mut model, null_mut());
//!     assert_eq!(opened, Status::Ok);
//!     let (mut camera, mut length) = (std::mem::zeroed(), 0);
//!     pnrf_default_camera(model, 64, 48, &mut camera, null_mut());
//!     pnrf_scratch_length(model, null(), &mut length, null_mut());
//!     let (mut scratch, mut pixels) = (vec![0.0; length], vec![0u8; 4 * 64 * 48]);
//!     let image = Image { pixels: pixels.as_mut_ptr().cast(), size: pixels.len(), ..std::mem::zeroed() };
//!     let rendered = pnrf_render(
//!         model, &camera, null(), &image, scratch.as_mut_ptr(), length, null_mut(), null_mut(),
//!     );
//!     assert_eq!(rendered, Status::Ok);
//!     assert!(pixels.iter().any(|byte| *byte > 100));
//!     pnrf_close(model);
//! }
//! ```
#![allow(clippy::missing_safety_doc, reason = "the one condition of all functions is stated above")]
#![allow(clippy::too_many_arguments, reason = "C has no slices: pointers and lengths")]

mod abi;
mod border;
mod camera;
mod image;
mod info;
mod model;
mod options;
mod pick;
mod query;
mod render;
mod status;
mod views;

pub use abi::ABI_VERSION;
pub use camera::{Camera, MAX_SIDE, pnrf_look_at};
pub use image::{Alpha, DepthKind, Format, Image};
pub use info::{Info, Text, pnrf_info, pnrf_text};
pub use model::{
    Model, OPEN_BORROWED, OPEN_MODEL_COORDINATES, OPEN_UNVERIFIED, OPEN_WITHOUT_TABLE, pnrf_close,
    pnrf_open_bytes, pnrf_open_file,
};
pub use options::{Memory, Options, Sampling, Simd, pnrf_default_options, pnrf_scratch_length};
pub use pick::{Hit, pnrf_pick};
pub use query::{
    Depth, pnrf_collision_probability, pnrf_density, pnrf_density_gradient, pnrf_depths,
    pnrf_normals, pnrf_occupied, pnrf_radiance, pnrf_segment_transmittance, pnrf_sphere_clear,
};
pub use render::{Stats, Tile, pnrf_render, pnrf_render_tile, pnrf_tile, pnrf_tile_count};
pub use status::{ERROR_TEXT, Error, Status, pnrf_status_text};
pub use views::{
    pnrf_default_camera, pnrf_orbit_camera, pnrf_photograph_camera, pnrf_photograph_count,
    pnrf_world,
};

/// The version of the library. It fits the header if the upper 16 bits equal those of
/// `PNRF_ABI_VERSION`, and the lower ones are not smaller.
#[unsafe(no_mangle)]
pub extern "C" fn pnrf_abi_version() -> u32 {
    ABI_VERSION
}
