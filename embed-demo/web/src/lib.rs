//! pocketnerf for web pages: renders a `.pnerf` file in tiles, or has a GPU do it, through
//! functions of numbers that a page calls without generated glue.
//!
//! An instance of the module shows one file and is dropped with it, so nothing needs to be freed.
//! No function takes a pointer: the module allocates memory and returns its address, where the
//! page writes files and cameras and reads pixels and answers between calls. Hence the module has
//! no unsafe code. Pages use it through `pocketnerf.js`.
//!
//! | call | what it does |
//! |---|---|
//! | [`input`](exports::input) | allocates memory for a file, which the page writes |
//! | [`open`](exports::open) | checks and opens it; [`facts`](exports::facts) and [`text`](exports::text) describe it |
//! | [`view`](exports::view), [`begin`](exports::begin) | the place of a camera; starts its picture, and counts its tiles |
//! | [`tile`](exports::tile), [`pixels`](exports::pixels) | renders one; its RGBA bytes |
//! | [`pack`](exports::pack), [`part`](exports::part) | what a GPU renders the file with |
//! | [`frame`](exports::frame), [`colors`](exports::colors), [`show`](exports::show) | what it is to know of a picture; its colours, as RGBA bytes |
//! | [`pick`](exports::pick), [`answer`](exports::answer) | what is at a point of the picture |
//!
//! A failure returns 0 (`pick`: a negative number), with the reason in
//! [`message`](exports::message).
//!
//! # Example
//! The calls of a page, in Rust; the camera is the file's own.
//! ```
//! use pocketnerf_web::{Scene, facts::Facts};
//!
//! let bytes = include_bytes!("../../still-life.pnerf");
//! let mut scene = Scene::open(bytes, pocketnerf_core::SimdLevel::compiled())?;
//! let facts: Facts = scene.facts();
//! let camera = scene.own_camera(64, 48);
//! let tiles = scene.begin(&camera, facts.quality())?;
//! let (_, pixels) = scene.tile(tiles / 2, false)?;
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
mod gpu;
#[cfg(target_family = "wasm")]
mod runtime;
mod scene;

pub use gpu::Parts;
pub use scene::{Scene, View};
