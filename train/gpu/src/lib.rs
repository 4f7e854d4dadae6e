//! Trains and renders radiance fields on GPUs, through wgpu: the steps of `pocketnerf-train`, and
//! the pictures of `pocketnerf-core`, every pixel of them.
//!
//! A [`Gpu`] is opened once. A [`training::Learner`] takes steps. A [`Renderer`] holds a model in the GPU's memory and has a
//! program compiled for it: [`pack`] lays the model out in buffers, [`shader`] writes the
//! program (WGSL) around its constants. It needs no optional feature of a GPU.
//!
//! # Features
//! * `wgpu` (default): runs the program. Without it, only `pack`, `shader` and [`Frame`] are
//!   there, for hosts that have a GPU's interface of their own, as web pages do; no standard
//!   library.
//! * `nerf`, `ndc`, `contracted`: vanilla NeRFs, forward-facing captures and scenes without an
//!   end, beside hash grids in a box; part of `wgpu`.
//!
//! # Example
#![cfg_attr(feature = "wgpu", doc = "```")]
#![cfg_attr(not(feature = "wgpu"), doc = "```ignore")]
//! use pocketnerf_core::{RenderOptions, SimdLevel, Tuning};
//! use pocketnerf_gpu::{Gpu, Renderer, Software};
//!
//! # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"),
//! #     "/../../embed-demo/still-life.pnerf"))?;
//! # let bytes = pocketnerf_formats::unpacked(&bytes)?;
//! let file = pocketnerf_formats::open(&bytes)?;
//! let camera = file.about.camera.expect("a trained model has one").camera();
//! // Software GPUs are for tests.
//! match Gpu::open(Software::Allowed) {
//!     Ok(gpu) => {
//!         let options = RenderOptions::new(&file.model, SimdLevel::detect(), Tuning::FAST);
//!         let mut renderer = Renderer::new(&gpu, &file.model, &options)?;
//!         let picture = renderer.render(&camera)?;
//!         assert_eq!(picture.rgba.len(), 4 * (picture.width * picture.height) as usize);
//!     }
//!     Err(why) => println!("{why}: render on the CPU"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(not(feature = "wgpu"), no_std)]
// But for `render/module.rs`.
#![deny(unsafe_code)]

extern crate alloc;

/// A file of the program, without comments.
macro_rules! wgsl {
    ($name:literal) => {
        include_str!(concat!(env!("OUT_DIR"), "/", $name, ".wgsl"))
    };
}

mod frame;
pub mod pack;
#[cfg(feature = "wgpu")]
mod render;
pub mod shader;
#[cfg(feature = "wgpu")]
pub mod training;

pub use frame::Frame;
#[cfg(feature = "wgpu")]
pub use render::{Error, Gpu, Picture, Renderer, Software, adapters};
