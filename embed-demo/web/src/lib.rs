//! pocketnerf for web pages: a `.pnerf` file in, tiles of pixels and answers out, by functions
//! of numbers that a page calls without any generated glue.
//!
//! One instance of the module shows one file, and goes when the file does: nothing needs to be
//! freed. No pointer ever comes in. The module makes room and says where; the page writes files
//! and cameras there, and reads pixels and answers from there, between two calls. So there is
//! nothing unsafe in it. `pocketnerf.js` beside this crate does all of that, and is what pages use.
//!
//! | call | what it does |
//! |---|---|
//! | [`input`](exports::input) | room for a file of so many bytes, which the page writes |
//! | [`open`](exports::open) | checks and opens it; [`facts`](exports::facts) and [`text`](exports::text) then tell about it |
//! | [`view`](exports::view), [`begin`](exports::begin) | where a camera is written; begins its picture, and counts its tiles |
//! | [`tile`](exports::tile), [`pixels`](exports::pixels) | renders one; its RGBA bytes, and where it lies |
//! | [`pick`](exports::pick), [`answer`](exports::answer) | what is at a point of the picture |
//!
//! What fails gives 0 (`pick`: a negative number), and [`message`](exports::message) says why.
//!
//! # Example
//! What the page does, in Rust's words; the camera is the file's own.
//! ```
//! use pocketnerf_web::{Scene, facts::Facts};
//!
//! let bytes = include_bytes!("../../still-life.pnerf");
//! let mut scene = Scene::open(bytes, pocketnerf_core::SimdLevel::compiled())?;
//! let facts: Facts = scene.facts();
//! let camera = scene.own_camera(64, 48);
//! let tiles = scene.begin(&camera, facts.quality())?;
//! let (_, pixels) = scene.tile(tiles / 2)?;
//! assert!(pixels.iter().any(|byte| *byte < 100));
//! # Ok::<(), String>(())
//! ```
#![no_std]
#![deny(unsafe_code)]

extern crate alloc;
#[cfg(not(target_family = "wasm"))]
extern crate std;

pub mod exports;
pub mod facts;
#[cfg(target_family = "wasm")]
mod runtime;
mod scene;

pub use scene::{Scene, View};
