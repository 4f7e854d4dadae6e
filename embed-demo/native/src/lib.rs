//! A window on a `.pnerf` file, rendered on the CPU, and what the program `pocketnerf-view`
//! is made of.
//!
//! [`view`] (the camera that goes around) and [`painter`] (tiles on all threads) know no
//! window; neither does [`show`], which decides what is painted next: a small picture while
//! things move, of the size that [`pace`] chooses, and the whole one when they rest.
//! [`app`] is the window: events to [`input`], pictures and [`overlay`] to the screen.
//! [`headless`] needs none.
#![forbid(unsafe_code)]

pub mod app;
pub mod cells;
pub mod figures;
pub mod headless;
pub mod input;
pub mod modes;
pub mod normals;
pub mod overlay;
pub mod pace;
pub mod painter;
pub mod picture;
pub mod screenshot;
pub mod script;
pub mod show;
pub mod status;
pub mod terminal;
pub mod view;

/// Why something did not work: one line.
pub type Failure = Box<dyn std::error::Error>;

/// A line on standard output. Who reads it may have gone: that is no fault.
pub fn say(text: &str) {
    use std::io::Write;
    let mut out = std::io::stdout();
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
}
