//! Renders radiance fields on GPUs, through wgpu: the pictures of `pocketnerf-core` at the
//! same quality, every pixel of them, in a fraction of the time.
//!
//! A [`Gpu`] is opened once. A [`Renderer`] holds a model in the GPU's memory and has a
//! program compiled for it: [`pack`] lays the model out in buffers, [`shader`] writes the
//! program (WGSL) around its constants. It needs no optional feature of a GPU.
//!
//! # Example
//! ```
//! use pocketnerf_core::{Camera, RenderOptions, SimdLevel, Tuning};
//! use pocketnerf_gpu::{Gpu, Renderer, Software};
//!
//! # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"),
//! #     "/../../embed-demo/still-life.pnerf"))?;
//! # let bytes = pocketnerf_formats::unpacked(&bytes)?;
//! let file = pocketnerf_formats::open(&bytes)?;
//! let camera = file.about.camera.expect("a trained model has one").camera();
//! // Programs that do as if they were a GPU are for tests.
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

#![forbid(unsafe_code)]

mod adapter;
mod bands;
mod error;
pub mod pack;
mod picture;
mod program;
mod renderer;
mod self_test;
pub mod shader;

pub use adapter::{Gpu, Software, adapters};
pub use error::Error;
pub use picture::Picture;
pub use renderer::Renderer;
