//! Posed images: what training and evaluation read.

use pocketnerf_core::Camera;

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
