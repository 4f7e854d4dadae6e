//! The text of the overlay.

use std::fmt::Write;

use crate::paint::modes::Mode;
use crate::show::Show;

/// The keys to start with.
pub(crate) const KEYS: &str = "drag, wheel, 1 2 3 4, q t r s, k p w; h hides this";

/// Figures of the picture, a few lines of plain text.
#[must_use]
pub(super) fn status(show: &Show<'_>, name: &str, note: &str) -> String {
    let (figures, picture) = (&show.figures, show.shown());
    let mut text = format!("{name}, {}, {}x{}", show.mode.name(), picture.width, picture.height);
    let mut line = |line: std::fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n{line}");
    };
    let (frame, fps, wanted) = (figures.frame_ms, figures.fps, show.pace.fps);
    line(format_args!("moving: {frame:.0} ms a frame, {fps:.0} frames/s (of {wanted:.0})"));
    match show.is_at_rest() {
        true => line(format_args!("scale 1, whole after {:.0} ms", figures.rest_ms)),
        false => line(format_args!("scale {:.2}", figures.scale)),
    }
    let (rays, samples) = (figures.stats.rays, figures.stats.samples);
    if show.mode == Mode::Colour || show.mode == Mode::Depth {
        let per_ray = samples as f64 / rays.max(1) as f64;
        line(format_args!("{rays} rays, {per_ray:.1} samples a ray"));
        let tolerance = show.painter().model().detail(figures.quality).tolerances[0];
        line(format_args!("quality {:.2}: tolerance {tolerance:.3}", figures.quality));
    } else {
        line(format_args!("{rays} rays"));
    }
    if let (true, Some(psnr)) = (show.is_at_rest(), figures.moving_psnr) {
        line(format_args!("last moving picture: {psnr:.1} dB of this one"));
    }
    if show.mode == Mode::Depth {
        let range = show.painter().range(&show.shot().camera);
        line(format_args!("red {:.2} to blue {:.2}", range.near, range.far));
    }
    if let Some(gpu) = show.painter().gpu() {
        line(format_args!("{gpu}"));
    }
    if !note.is_empty() {
        line(format_args!("{note}"));
    }
    line(format_args!("{KEYS}"));
    text
}
