//! Trains radiance fields on ordinary CPUs.
//!
//! [`dataset`] reads images and cameras, [`trainer`] learns a field from them,
//! `pocketnerf-formats` writes it down; [`evaluate`] and [`picture`] look at it.
//! The program `pocketnerf` is the crate beside it, `train/cli`.
//!
//! # Example
//! ```
//! use std::time::Instant;
//!
//! use pocketnerf_core::SimdLevel;
//! use pocketnerf_formats::{About, Precision};
//! use pocketnerf_train::dataset::Split;
//! use pocketnerf_train::metrics::Metrics;
//! use pocketnerf_train::trainer::{Length, TrainConfig, Trainer, run};
//! use pocketnerf_train::{builtin, evaluate, picture};
//!
//! // The built-in scene as thumbnails, a coarse grid, and a few steps.
//! let simd = SimdLevel::detect();
//! let mut config = TrainConfig::hash_grid();
//! config.aabb = Some([[-1.4; 3], [1.4; 3]]);
//! config.occupancy_resolution = 32;
//! config.samples_per_side = 64.0;
//! config.samples_per_step = 4096;
//! let mut trainer = Trainer::with_prepass(builtin::dataset(Split::Train, 16), config, simd)?;
//! run(&mut trainer, Length::Steps(300), Instant::now(), |_| ())?;
//! let bytes = pocketnerf_formats::write(&trainer.model(), &About::default(), Precision::F16)?;
//!
//! // Any program: from the bytes to new views.
//! let file = pocketnerf_formats::open_verified(&bytes)?;
//! let held_out = builtin::dataset(Split::Test, 16);
//! let settings = picture::Settings::default();
//! let rendered = picture::render(&file.model, &held_out.views[0].camera, &settings)?;
//! assert_eq!(rendered.over([1.0; 3]).len(), 3 * 25 * 25);
//! let metrics = Metrics::default();
//! let score =
//!     evaluate::evaluate(&file.model, &held_out, [1.0; 3], &settings, &metrics, |_, _, _| ())?;
//! assert!(score.psnr > 17.0, "{} dB", score.psnr);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[doc(hidden)]
pub mod aligned;
pub mod builtin;
pub mod cameras;
pub mod compact;
pub mod convert;
pub mod dataset;
pub mod evaluate;
pub mod field;
pub mod json;
pub mod lens;
pub mod metrics;
pub mod output;
pub mod picture;
mod pool;
pub mod pose;
mod presets;
mod probe;
pub mod random;
#[doc(hidden)]
pub mod stopwatch;
pub mod surface;
pub mod trainer;
