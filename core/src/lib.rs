//! Renders radiance fields straight from the bytes of a model: no heap, no
//! threads, no operating system, no `unsafe`.
//!
//! The modules stand in the order in which a ray passes through them:
//! [`camera`] → [`space`] → [`occupancy`] → [`march`] → [`encoding`] →
//! [`network`] → [`field`] → [`render`]. Other questions to a model are in [`query`].
//!
//! # Features
//! * `std` (default): detects the machine's SIMD level; everything else is the
//!   same without it.
//! * `hash-grid`, `nerf` (default): kinds of field, at least one; `nerf` also is the
//!   paper's sampling.
//! * `ndc`, `contracted` (default): the spaces of forward-facing captures and of scenes without
//!   an end, beside boxes.
//!
//! # Example
//! A fog that is denser to the right; `pocketnerf-formats` reads such a model from a file.
#![cfg_attr(all(feature = "std", feature = "hash-grid"), doc = "```")]
#![cfg_attr(not(all(feature = "std", feature = "hash-grid")), doc = "```ignore")]
//! use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
//! use pocketnerf_core::field::{Decoder, HashGridField, Shading};
//! use pocketnerf_core::network::{Dense, Mlp};
//! use pocketnerf_core::{
//!     AnyField, Camera, ColorSpace, DType, Display, Layout, Model, RenderOptions, Sampling,
//!     SimdLevel, Space, TensorView, Tile, Tuning, render_tile,
//! };
//!
//! // A grid of 4x4x4 corners, in blocks of 2x2x2, whose values interpolate to the scene's x;
//! // x to log density and a feature; the feature and a constant to a colour.
//! let config = HashGridConfig {
//!     n_levels: 1,
//!     n_features_per_level: 1,
//!     log2_hashmap_size: 6,
//!     base_resolution: 2,
//!     per_level_scale: 1.0,
//!     index: GridIndex::Blocked,
//! };
//! let corner_x = |entry: usize| entry / 8 % 2 * 2 + entry % 2;
//! let grid: Vec<f32> = (0..64).map(|entry| 2.0 * corner_x(entry) as f32 - 2.0).collect();
//! let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
//! let (grid, density) = (bytes(&grid), bytes(&[2.0, 1.0]));
//! let color = bytes(&[3.0, 0.0, -3.0, 0.0, 0.0, 0.0]);
//! let tensor = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
//! let layer = |bytes, shape| Mlp::new(&[Dense { weight: tensor(bytes, shape)?, bias: None }]);
//! let mut levels = [TensorView::EMPTY; MAX_LEVELS];
//! levels[0] = tensor(&grid, [64, 1])?;
//! let model = Model {
//!     field: AnyField::HashGrid(HashGridField {
//!         grid: HashGrid { config, levels },
//!         decoder: Decoder {
//!             density: layer(&density, [1, 2])?,
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

// Weights are read where they lie, and so are the numbers in a caller's scratch.
#[cfg(target_endian = "big")]
compile_error!("pocketnerf-core needs a little-endian machine, as model files hold such numbers");

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
