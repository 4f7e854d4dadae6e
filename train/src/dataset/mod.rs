//! Posed images: what training and evaluation read.
//!
//! One file per convention, recognised by content.

mod blender;
mod error;
mod fingerprint;
mod images;
mod recognise;
mod report;

use std::fmt;
use std::path::Path;

use pocketnerf_core::Camera;

pub use error::DatasetError;
pub(crate) use report::nearest_to_axes;
pub use report::{DatasetReport, ImageSize, SplitReport, inspect};

use recognise::{Convention, recognise};

/// Reads one split of the dataset in the folder `path`: every frame, in the
/// dataset's order, with images `downscale_factor` times smaller along each
/// side (1 keeps them).
///
/// # Errors
/// One line: which file, what was found, what was expected and what to do.
pub fn load(path: &Path, split: Split, downscale_factor: u32) -> Result<Dataset, DatasetError> {
    match recognise(path)? {
        Convention::Blender => blender::load(path, split, downscale_factor),
    }
}

impl Dataset {
    /// Keeps at most `n` views, spread evenly.
    pub fn thin(&mut self, n: usize) {
        let all = self.views.len();
        if n < all {
            let mut number = 0..all;
            // The first view, and then each that begins another n-th part.
            self.views.retain(|_| number.next().is_some_and(|i| i * n % all < n));
        }
    }
}

/// Which part of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Split {
    /// Views to learn from.
    Train,
    /// Views to choose settings with.
    Val,
    /// Views to report on.
    Test,
}

impl Split {
    /// All splits.
    pub const ALL: [Self; 3] = [Self::Train, Self::Val, Self::Test];

    /// `train`, `val` or `test`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Val => "val",
            Self::Test => "test",
        }
    }
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Split {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|split| split.name() == text)
            .ok_or_else(|| format!("{text:?} is no split, expected train, val or test"))
    }
}

/// One image and the camera that took it.
#[derive(Clone, Debug)]
pub struct View {
    /// What names the view in reports: the image's path relative to the dataset.
    pub name: String,
    /// The camera; its size is the image's.
    pub camera: Camera,
    /// `width * height` pixels, row after row from the top, straight (not
    /// premultiplied) RGBA; alpha 255 where the image has none.
    pub rgba: Vec<u8>,
    /// Euclidean distance along each pixel's ray to the first surface, scene
    /// units, where it is known exactly; infinite where the ray meets nothing.
    pub depth: Option<Vec<f32>>,
}

impl View {
    /// Whether any pixel is transparent.
    #[must_use]
    pub fn has_alpha(&self) -> bool {
        self.rgba.iter().skip(3).step_by(4).any(|&alpha| alpha < 255)
    }
}

/// The views of one split.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// What was loaded: a path, or the name of the built-in scene.
    pub source: String,
    /// The convention that was recognised.
    pub format: &'static str,
    /// Which split.
    pub split: Split,
    /// The views, in the dataset's order.
    pub views: Vec<View>,
    /// Whether any image has transparent pixels.
    pub has_alpha: bool,
}
