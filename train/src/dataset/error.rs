//! Why a dataset was refused: one line each, with the file, what was found,
//! what was expected and what to do.

use std::path::PathBuf;

use crate::json::{JsonError, escape, one_line};
use crate::pose::PoseProblem;

/// Why a dataset was refused. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// Nothing lies at the path.
    #[error("{}: no such folder; give the folder that holds transforms_train.json", one_line(.0))]
    Missing(PathBuf),
    /// The path is not a folder.
    #[error(
        "{}: this is a file, expected a dataset's folder; give the folder that holds transforms_train.json",
        one_line(.0)
    )]
    NotAFolder(PathBuf),
    /// The folder cannot be listed.
    #[error("{}: cannot be listed: {source}; check its permissions", one_line(.folder))]
    Unlistable {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Nothing in the folder.
    #[error(
        "{}: the folder is empty; expected transforms_train.json and its images (Blender convention)",
        one_line(.0)
    )]
    Empty(PathBuf),
    /// No convention was recognised.
    #[error(
        "{}: no dataset recognised; found {}; expected transforms_train.json, transforms_val.json, transforms_test.json \
         (Blender convention){}",
        one_line(.folder), escape(.found),
        .inside.as_ref().map(|inner| format!("; \"{}\" inside it is one: give that folder", escape(inner))).unwrap_or_default()
    )]
    NotRecognised {
        /// The folder.
        folder: PathBuf,
        /// The first few names in it.
        found: String,
        /// A folder inside which holds a dataset.
        inside: Option<String>,
    },
    /// A convention that cannot be read yet.
    #[error(
        "{}: {convention} dataset ({sign}), which is recognised but not supported yet; supported: Blender transforms_train.json, \
         transforms_val.json, transforms_test.json with camera_angle_x and undistorted images",
        one_line(.path)
    )]
    NotSupported {
        /// The file or folder.
        path: PathBuf,
        /// The convention's name.
        convention: &'static str,
        /// What it was recognised by.
        sign: String,
    },
    /// The dataset has no such split.
    #[error("{}: no such file, so there is no {split} split; this dataset has {has}", one_line(.file))]
    NoSplit {
        /// The file that would hold the split.
        file: PathBuf,
        /// The split's name.
        split: &'static str,
        /// The splits that are there.
        has: String,
    },
    /// A JSON file is wrong.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A JSON file without frames.
    #[error("{}: \"frames\" is empty, expected at least one frame; re-export the dataset", one_line(.0))]
    NoFrames(PathBuf),
    /// A JSON file without a field of view.
    #[error("{}: no \"camera_angle_x\"; expected the horizontal field of view in radians", one_line(.0))]
    NoFieldOfView(PathBuf),
    /// A field of view that no camera has.
    #[error(
        "{}: camera_angle_x is {angle}, expected radians from 0.01 to below pi{}",
        one_line(.file),
        if *.angle >= std::f64::consts::PI { "; degrees must be converted" } else { "" }
    )]
    FieldOfView {
        /// The file.
        file: PathBuf,
        /// What was found.
        angle: f64,
    },
    /// A pose is wrong.
    #[error("{}: frame {frame} (\"{}\"): {problem}", one_line(.file), escape(.name))]
    Pose {
        /// The JSON file.
        file: PathBuf,
        /// The frame's place in the list, from 0.
        frame: usize,
        /// The frame's `file_path`.
        name: String,
        /// What is wrong.
        problem: PoseProblem,
    },
    /// Images are missing.
    #[error(
        "{}: no such image (nor with .png, .jpg or .jpeg added); {} lists {total} frames and {missing} of their images missing: \
         add the images or take the frames out of the list",
        one_line(.image), one_line(.file)
    )]
    MissingImage {
        /// The first image that is missing.
        image: PathBuf,
        /// The JSON file that lists it.
        file: PathBuf,
        /// How many images are missing.
        missing: usize,
        /// How many frames there are.
        total: usize,
    },
    /// An image cannot be decoded.
    #[error("{}: unreadable image: {}; expected a whole PNG or JPEG file", one_line(.image), escape(.problem))]
    UnreadableImage {
        /// The image.
        image: PathBuf,
        /// The decoder's reason.
        problem: String,
    },
    /// An image has another size than the first one.
    #[error(
        "{}: {}x{} pixels, but {} has {}x{}; expected images of one size, since they share one camera_angle_x",
        one_line(.image), .size[0], .size[1], one_line(.first), .first_size[0], .first_size[1]
    )]
    ImageSize {
        /// The image.
        image: PathBuf,
        /// Its width and height.
        size: [u32; 2],
        /// The first image.
        first: PathBuf,
        /// Its width and height.
        first_size: [u32; 2],
    },
    /// Images cannot be made smaller by this factor.
    #[error("downscale factor {factor}: expected 1 to {largest} for images of {}x{}", .size[0], .size[1])]
    DownscaleFactor {
        /// What was asked for.
        factor: u32,
        /// The largest that leaves a pixel.
        largest: u32,
        /// The images' width and height.
        size: [u32; 2],
    },
}
