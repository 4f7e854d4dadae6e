//! Renders radiance fields straight from the bytes of a model: no heap, no
//! threads, no operating system, no `unsafe`.
//!
//! The modules stand in the order in which a ray passes through them:
//! [`camera`] → [`space`] → [`occupancy`] → [`march`] → [`encoding`] →
//! [`network`] → [`field`] → [`render`]. What else a program may ask of a
//! model stands in [`query`].
//!
//! # Features
//! * `std` (default): detects the machine's SIMD level; everything else is the
//!   same without it.
//! * `hash-grid`, `frequency`, `nerf` (default): kinds of field, at least one; `nerf` also is
//!   the paper's sampling.
//! * `ndc` (default): the space of forward-facing captures, beside boxes.
//!
//! # Example
//! A fog that is denser to the right, from 24 numbers; `pocketnerf-formats` reads
//! such a model from a file.
#![cfg_attr(all(feature = "std", feature = "frequency"), doc = "```")]
#![cfg_attr(not(all(feature = "std", feature = "frequency")), doc = "```ignore")]
//! use pocketnerf_core::encoding::FrequencyConfig;
//! use pocketnerf_core::field::{Decoder, FrequencyField, Shading};
//! use pocketnerf_core::network::{Dense, Mlp};
//! use pocketnerf_core::{
//!     AnyField, Camera, ColorSpace, DType, Display, Layout, Model, RenderOptions, Sampling,
//!     SimdLevel, Space, TensorView, Tile, Tuning, render_tile,
//! };
//!
//! // Position and its sines and cosines, 9 values, to log density and a feature:
//! // x goes to both. The feature and a constant to a colour.
//! let mut density = [0f32; 18];
//! [density[0], density[1]] = [2.0, 1.0];
//! let color = [3f32, 0.0, -3.0, 0.0, 0.0, 0.0];
//! let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
//! let (density, color) = (bytes(&density), bytes(&color));
//! let layer = |bytes, shape| {
//!     let weight = TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor)?;
//!     Mlp::new(&[Dense { weight, bias: None }])
//! };
//! let model = Model {
//!     field: AnyField::Frequency(FrequencyField {
//!         encoding: FrequencyConfig { n_frequencies: 1, include_input: true },
//!         decoder: Decoder {
//!             density: layer(&density, [9, 2])?,
//!             color: layer(&color, [2, 3])?,
//!             n_features: 1,
//!             sh_degree: 1,
//!             shading: Shading::PerRay,
//!             log_density_bias: 0.0,
//!         },
//!     }),
//!     space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
//!     occupancy: None,
//!     sampling: Sampling { step: 0.05, near: 0.0, far: 6.0, min_transmittance: 1e-3 },
//!     hierarchical: None,
//!     display: Display { background: [1.0; 3], color_space: ColorSpace::Srgb, tolerance: Display::TOLERANCE },
//! };
//!
//! let pose = Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0]);
//! let camera = Camera::from_fov_x(32, 24, 0.6, pose);
//! let options = RenderOptions::new(&model, SimdLevel::detect(), Tuning::SMALL);
//! let mut scratch = vec![0.0; options.scratch_len()];
//! let mut rgba = vec![0.0; 4 * 32 * 24];
//! let tile = Tile { x: 0, y: 0, width: 32, height: 24 };
//! render_tile(&model, &camera, tile, &options, &mut scratch, &mut rgba, None)?;
//!
//! let alpha = |x: usize, y: usize| rgba[4 * (y * 32 + x) + 3];
//! assert!(alpha(4, 12) < 0.5 && alpha(27, 12) > 0.9);
//! # Ok::<(), pocketnerf_core::Error>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod camera;

pub mod encoding;
pub mod error;
pub mod field;
pub mod lanes;
pub mod march;
pub mod math;
pub mod model;
pub mod network;
pub mod occupancy;
pub mod pixel;
pub mod query;
pub mod reference;
pub mod render;
pub mod scratch;
pub mod simd;
pub mod space;
pub mod store;
pub mod tensor;

pub use camera::{Camera, Ray};
pub use error::Error;
pub use field::AnyField;
pub use march::Sampling;
pub use model::{ColorSpace, Display, Model};
pub use occupancy::Occupancy;
pub use query::Probe;
pub use render::{RenderOptions, SamplingMode, Tile, render_tile};
pub use scratch::{Limits, Tuning};
pub use simd::SimdLevel;
pub use space::Space;
pub use tensor::{DType, Layout, TensorView};
