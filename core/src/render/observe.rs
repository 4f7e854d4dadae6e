//! Rendering that reports what it is doing: to measure it. The core
//! reads no clock itself.

use crate::march::Stage;
use crate::render::driver::{self, Job};
use crate::render::passes::Span;
use crate::render::source::Pixels;
use crate::render::{RenderOptions, RenderStats, Tile};
use crate::{Camera, Error, Model};

/// Is called when a part of a stage has ended, with the number of pixels,
/// rays (`Camera`, `Shade`) or samples that it dealt with.
pub type Observer<'o> = dyn FnMut(Stage, usize) + 'o;

/// [`render_tile`](crate::render_tile), observed: the same pixels.
///
/// # Errors
/// As `render_tile`.
pub fn observe_tile(
    model: &Model<'_>,
    camera: &Camera,
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    observer: &mut Observer<'_>,
) -> Result<RenderStats, Error> {
    let (source, span) = (&Pixels { camera, tile }, Span::all(options.detail.spacing()));
    driver::render(&Job { model, source, options, span }, scratch, rgba, None, Some(observer))
}
