//! What a convention's files say before any image is decoded.

use std::path::PathBuf;

use super::Own;
use super::intrinsics::Intrinsics;
use crate::lens::Lens;

/// The frames of one split, checked, and what is known of the scene.
#[derive(Debug)]
pub(super) struct Listing {
    /// The convention's name in reports.
    pub(super) format: &'static str,
    /// What it was recognised by.
    pub(super) sign: String,
    /// What images' names are relative to.
    pub(super) folder: PathBuf,
    /// The file that lists the frames, or the folder that holds them.
    pub(super) file: PathBuf,
    /// In the dataset's order; at least one.
    pub(super) frames: Vec<Frame>,
    /// Whether the splits are not the dataset's own, but held out.
    pub(super) is_one_set: bool,
    /// Images that are missing, of frames that were left out for that.
    pub(super) left_out: Vec<String>,
    /// The factor by which images must be downscaled; `None`: the requested one.
    pub(super) factor: Option<u32>,
    /// Near and far, scene units.
    pub(super) bounds: Option<[f32; 2]>,
    /// The scene's box, smallest and largest corner.
    pub(super) aabb: Option<[[f32; 3]; 2]>,
    /// The box around what opaque images show, where points of the scene are known.
    pub(super) reach: Option<[[f32; 3]; 2]>,
    /// Colour behind opaque images.
    pub(super) background: Option<[f32; 3]>,
    /// Whether rays suit normalised device coordinates.
    pub(super) forward_facing: bool,
    /// The coordinates of its files, where it was moved.
    pub(super) own: Option<Own>,
    /// Metres per unit of its files, where that is known.
    pub(super) metres: Option<f32>,
    /// What the user should know, a line each.
    pub(super) notes: Vec<String>,
}

/// One frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// The image relative to the dataset's folder, with forward slashes and without `./`.
    pub(super) path: String,
    /// Camera-to-world, row after row, OpenGL camera axes.
    pub(super) pose: [f32; 16],
    pub(super) intrinsics: Intrinsics,
    pub(super) lens: Lens,
    /// Which pixels count.
    pub(super) mask: Option<Mask>,
    /// Another image whose red channel is this one's alpha.
    pub(super) alpha: Option<String>,
    /// This part of the width does not count along each edge.
    pub(super) edge: f64,
}

impl Frame {
    /// A frame of which nothing else is known.
    pub(super) fn new(path: String, pose: [f32; 16], intrinsics: Intrinsics, lens: Lens) -> Self {
        Self { path, pose, intrinsics, lens, mask: None, alpha: None, edge: 0.0 }
    }

    pub(super) fn is_fisheye(&self) -> bool {
        matches!(self.lens, Lens::Fisheye(_))
    }
}

/// An image that says which pixels count.
#[derive(Clone, Debug)]
pub(super) struct Mask {
    /// Relative to the dataset's folder.
    pub(super) path: String,
    /// Whether black pixels are those that count, or the others.
    pub(super) black_counts: bool,
    /// Whether it may be as large as the image was before that was made smaller.
    pub(super) may_be_larger: bool,
}

impl Listing {
    /// Frames of a file, and nothing known of the scene.
    pub(super) fn new(
        format: &'static str,
        sign: String,
        file: PathBuf,
        frames: Vec<Frame>,
    ) -> Self {
        Self {
            format,
            sign,
            folder: PathBuf::new(),
            file,
            frames,
            is_one_set: false,
            left_out: Vec::new(),
            factor: None,
            bounds: None,
            aabb: None,
            reach: None,
            background: None,
            forward_facing: false,
            own: None,
            metres: None,
            notes: Vec::new(),
        }
    }
}

/// Forward slashes, no `./` in front.
pub(super) fn relative_path(file_path: &str) -> String {
    let path = file_path.replace('\\', "/");
    let mut rest = path.as_str();
    while let Some(shorter) = rest.strip_prefix("./") {
        rest = shorter;
    }
    rest.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_plain() {
        for (given, expected) in [
            ("./train/r_0", "train/r_0"),
            ("train\\r_0.png", "train/r_0.png"),
            (".\\./train/r_0", "train/r_0"),
            ("../train/r_0", "../train/r_0"),
        ] {
            assert_eq!(relative_path(given), expected);
        }
    }
}
