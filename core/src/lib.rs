//! Renders radiance fields straight from the bytes of a model: no heap, no
//! threads, no operating system, no `unsafe`.
//!
//! The modules stand in the order in which a ray passes through them:
//! [`camera`] → [`space`] → [`occupancy`] → [`sampler`] → [`encoding`] →
//! [`network`] → [`field`] → [`composite`] → [`render`].
#![no_std]
#![forbid(unsafe_code)]

pub mod camera;
pub mod composite;
pub mod encoding;
pub mod error;
pub mod field;
pub mod lanes;
pub mod math;
pub mod model;
pub mod network;
pub mod occupancy;
pub mod reference;
pub mod render;
pub mod sampler;
pub mod scratch;
pub mod simd;
pub mod space;
pub mod store;
pub mod tensor;

pub use camera::{Camera, Ray};
pub use error::Error;
pub use field::AnyField;
pub use model::{ColorSpace, Display, Model};
pub use occupancy::Occupancy;
pub use render::{RenderOptions, Tile, render_tile};
pub use sampler::Sampling;
pub use scratch::{Limits, Tuning};
pub use simd::SimdLevel;
pub use space::Space;
pub use tensor::{DType, Layout, TensorView};
