//! A frame of a dataset, with what its image's header says.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use pocketnerf_core::Camera;
use rayon::prelude::*;

use crate::dataset::images::{self, Header};
use crate::dataset::listing::{Frame, Listing};
use crate::dataset::turn::{Turn, turn};
use crate::dataset::{Split, decode};

/// A frame, and its image's header.
#[derive(Debug)]
pub(super) struct Shot<'l> {
    pub(super) split: Split,
    pub(super) folder: &'l Path,
    pub(super) frame: &'l Frame,
    /// Where the image lies; `None`: it is missing.
    pub(super) file: Option<PathBuf>,
    /// `None`: the image is missing, or cannot be read.
    pub(super) header: Option<Header>,
    /// What is done about its orientation; where it is turned, the header's size is the turned one.
    pub(super) turn: Turn,
    /// `None`: there is no header, or the image's shape is not that of its camera.
    pub(super) camera: Option<Camera>,
}

impl<'l> Shot<'l> {
    /// The frames of a split.
    pub(super) fn all(split: Split, listing: &'l Listing) -> Vec<Self> {
        let Listing { folder, frames, .. } = listing;
        let shot = |frame: &'l Frame| {
            let file = images::find(folder, &frame.path).map(|name| folder.join(name));
            let mut header = file.as_deref().and_then(images::header);
            let turn = header.map_or(Turn::None, |h| turn(h.size, h.orientation, frame));
            if let (Some(header), Turn::Turned) = (&mut header, turn) {
                header.size.reverse();
            }
            let camera =
                header.and_then(|h| decode::camera(folder, &frame.path, frame, h.size).ok());
            Self { split, folder, frame, file, header, turn, camera }
        };
        frames.par_iter().map(shot).collect()
    }

    /// The image as the dataset names it.
    pub(super) fn name(&self) -> &'l str {
        &self.frame.path
    }

    /// Equal where frames are, as where splits share them.
    pub(super) fn key(&self) -> (&'l Path, &'l str, [u32; 16]) {
        (self.folder, &self.frame.path, self.frame.pose.map(f32::to_bits))
    }
}

/// The frames of all splits, each once, but those that one split lists twice.
pub(super) fn distinct<'s, 'l>(splits: &'s [Vec<Shot<'l>>]) -> Vec<&'s Shot<'l>> {
    let (mut known, mut shots) = (HashSet::new(), Vec::new());
    for split in splits {
        shots.extend(split.iter().filter(|shot| !known.contains(&shot.key())));
        known.extend(split.iter().map(Shot::key));
    }
    shots
}
