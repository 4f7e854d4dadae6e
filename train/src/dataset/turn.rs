//! Photographs that EXIF says are to be turned: whether cameras were found for the pixels as they
//! are stored, or as viewers show them.
//!
//! Most programs use what is stored: COLMAP, instant-ngp, nerfstudio, Metashape. The size that a
//! camera is for tells, where the image is no square; else pixels stay as they are stored, and
//! that is said.

use image::metadata::Orientation;

use super::images::{Image, Stored, swaps};
use super::listing::Frame;
use crate::json::escape;

/// What was done about an image's orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// It has none, or its camera is for the pixels as they are stored.
    None,
    /// It was turned, as its camera asks.
    Turned,
    /// Its camera does not tell: it stays.
    Untold,
}

/// What is to be done about a frame's image of this size, as it is stored.
pub(super) fn turn([width, height]: [u32; 2], orientation: Orientation, frame: &Frame) -> Turn {
    if orientation == Orientation::NoTransforms {
        return Turn::None;
    }
    let tells = swaps(orientation) && frame.intrinsics.size.is_some();
    let fits = [[width, height], [height, width]].map(|size| frame.intrinsics.fits(size));
    match (tells, fits) {
        (true, [true, false]) => Turn::None,
        (true, [false, true]) => Turn::Turned,
        // It fits neither way, which is refused.
        (true, [false, false]) => Turn::None,
        _ => Turn::Untold,
    }
}

/// A frame's image, turned if its camera is for that.
pub(super) fn upright(stored: Stored, frame: &Frame) -> (Image, Turn) {
    let Stored { image, orientation, .. } = stored;
    let turn = turn(image.size, orientation, frame);
    let image = if turn == Turn::Turned { image.turned(orientation) } else { image };
    (image, turn)
}

/// Of how many images something is to be said, and the first one's name.
#[derive(Debug, Default)]
pub(super) struct Found {
    turned: (usize, String),
    untold: (usize, String),
    linear: (usize, String),
}

impl Found {
    pub(super) fn add(&mut self, turn: Turn, was_linear: bool, name: &str) {
        let count = |(count, first): &mut (usize, String), is_one: bool| {
            if is_one && *count == 0 {
                *first = escape(name);
            }
            *count += usize::from(is_one);
        };
        count(&mut self.turned, turn == Turn::Turned);
        count(&mut self.untold, turn == Turn::Untold);
        count(&mut self.linear, was_linear);
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let say = |(count, first): &(usize, String), what: &str| {
            (*count > 0).then(|| format!("{count} images (first: {first}) {what}"))
        };
        let untold = "have an EXIF orientation, and their cameras do not tell whether it counts: \
                      they stay as stored; if views are mixed up, turn the pixels and find the \
                      cameras again";
        let linear = "have linear colours: they are converted with the sRGB curve, and what is \
                      brighter than 1 is cut off";
        [
            say(&self.turned, "are turned by their EXIF orientation, as their cameras ask"),
            say(&self.untold, untold),
            say(&self.linear, linear),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
