//! The parts of `pocketnerf-view`: a window on a `.pnerf` file, rendered on the CPU, or, with
//! the cargo feature `gpu`, on a GPU.
//!
//! * [`view`]: the camera that turns around the scene.
//! * [`paint`]: pictures of a model, tiles on all threads.
//! * [`show`]: chooses what is painted next: a small picture while something moves, of a size
//!   that [`show::pace`] chooses, and the complete one at rest.
//! * [`window`]: passes events to `show`, and pictures to the screen. The only part that knows
//!   a window system.
//! * [`live`]: a model that is still learnt.
//! * [`output`]: pictures without a window.
//! * [`options`], [`program`]: the command line.
#![forbid(unsafe_code)]

pub mod live;
pub mod options;
pub mod output;
pub mod paint;
pub mod program;
pub mod show;
pub mod view;
pub mod window;

/// Why something failed: one line.
pub type Failure = Box<dyn std::error::Error>;

/// Prints a line on standard output. It is no error if nobody reads it.
pub fn say(text: &str) {
    use std::io::Write;
    let mut out = std::io::stdout();
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
}
