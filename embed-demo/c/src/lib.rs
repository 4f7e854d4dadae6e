//! pocketnerf for C and C++: open a `.pnerf` file, render it, ask it questions.
//!
//! The header is `include/pocketnerf.h`, made of this crate; its comments are this crate's.
//! Rust programs use `pocketnerf-core` and `pocketnerf-formats` instead.
//!
//! Every function checks what it is given, as far as that can be checked: null, alignment,
//! lengths, codes, numbers. What is wrong comes back as a [`Status`] and a line of text; nothing
//! has been written then. No panic leaves the library, which has no global state, starts no thread
//! and prints nothing. That memory is there, and that nobody else writes to it during a
//! call, is the caller's promise: the one safety condition of all functions here.
//!
//! # Example
//! What C does, in Rust's words: a picture of a file's own view.
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

mod border;
mod camera;
mod image;
mod info;
mod model;
mod options;
mod query;
mod render;
mod status;

pub use camera::{Camera, MAX_SIDE, pnrf_default_camera, pnrf_look_at};
pub use image::{Alpha, DepthKind, Format, Image};
pub use info::{Info, Text, pnrf_info, pnrf_text};
pub use model::{
    Model, OPEN_BORROWED, OPEN_MODEL_COORDINATES, OPEN_UNVERIFIED, OPEN_WITHOUT_TABLE, pnrf_close,
    pnrf_open_bytes, pnrf_open_file,
};
pub use options::{Memory, Options, Sampling, Simd, pnrf_default_options, pnrf_scratch_length};
pub use query::{
    Depth, pnrf_collision_probability, pnrf_density, pnrf_density_gradient, pnrf_depths,
    pnrf_normals, pnrf_occupied, pnrf_radiance, pnrf_segment_transmittance, pnrf_sphere_clear,
};
pub use render::{Stats, Tile, pnrf_render, pnrf_render_tile, pnrf_tile, pnrf_tile_count};
pub use status::{ERROR_TEXT, Error, Status, pnrf_status_text};

/// The version of this interface: 65536 times the major number, plus the minor. Within a major
/// number nothing that is there changes; the minor grows with what is added.
pub const ABI_VERSION: u32 = 65536;

/// The version that the library was built with, to be compared with the header's
/// `PNRF_ABI_VERSION`: the upper 16 bits equal, the lower ones not smaller.
#[unsafe(no_mangle)]
pub extern "C" fn pnrf_abi_version() -> u32 {
    ABI_VERSION
}
