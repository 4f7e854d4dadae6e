//! The original NeRF's convention: `transforms_{train,val,test}.json` beside
//! their images.
//!
//! `camera_angle_x` is the horizontal field of view in radians, shared by all
//! frames: focal = 0.5 · width / tan(0.5 · angle) pixels, principal point in
//! the middle. `transform_matrix` is camera-to-world with OpenGL camera axes,
//! row after row. `file_path` is relative to the folder, with or without its
//! extension. `rotation` means nothing.

use std::path::Path;

use serde::Deserialize;

use super::intrinsics::Intrinsics;
use super::listing::{Frame, Listing, relative_path};
use super::recognise::dialect;
use super::{DatasetError, Split, transforms};
use crate::json::{self, Keys};
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
pub(super) const FORMAT: &str = "blender";

const EXPECTED: &str = "a Blender dataset: {\"camera_angle_x\": radians, \"frames\": [{\"file_path\": \"./train/r_0\", \
     \"transform_matrix\": 4 rows of 4 numbers}, …]}";

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct RawFrames {
    camera_angle_x: Option<f64>,
    frames: Vec<RawFrame>,
}

#[derive(Deserialize)]
#[serde(expecting = "a frame")]
struct RawFrame {
    file_path: String,
    transform_matrix: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct FrameKeys {
    frames: Vec<Keys>,
}

/// The JSON file of a split.
pub(super) fn file_name(split: Split) -> &'static str {
    match split {
        Split::Train => "transforms_train.json",
        Split::Val => "transforms_val.json",
        Split::Test => "transforms_test.json",
    }
}

/// Reads and checks the JSON file of a split; looks at no image. A file with intrinsics
/// that this convention does not know is one of [`transforms`], and read as such.
pub(super) fn list(folder: &Path, split: Split) -> Result<Listing, DatasetError> {
    let name = file_name(split);
    let file = folder.join(name);
    if !file.is_file() {
        let has: Vec<&str> = Split::ALL
            .into_iter()
            .filter(|&other| folder.join(file_name(other)).is_file())
            .map(Split::name)
            .collect();
        return Err(DatasetError::NoSplit { file, split: split.name(), has: has.join(", ") });
    }
    let text = json::read(&file)?;
    let raw: RawFrames = json::parse(&text, &file, EXPECTED)?;
    if is_of_another_dialect(&text, &file)? {
        return transforms::list_file(folder, name);
    }
    if raw.frames.is_empty() {
        return Err(DatasetError::NoFrames(file));
    }
    let angle = raw.camera_angle_x.ok_or_else(|| DatasetError::NoFieldOfView(file.clone()))?;
    if !(0.01..std::f64::consts::PI).contains(&angle) {
        return Err(DatasetError::FieldOfView { file, angle });
    }
    let intrinsics = Intrinsics::from_fov_x(angle);
    let mut frames = Vec::with_capacity(raw.frames.len());
    for (index, frame) in raw.frames.into_iter().enumerate() {
        let path = relative_path(&frame.file_path);
        match pose::from_rows(&frame.transform_matrix) {
            Ok(pose) => {
                frames.push(Frame::new(path, pose, intrinsics, Lens::Pinhole));
            }
            Err(problem) => {
                let name = frame.file_path;
                return Err(DatasetError::Pose { file, frame: index, name, problem });
            }
        }
    }
    Ok(Listing::new(FORMAT, name.to_owned(), file, frames))
}

fn is_of_another_dialect(text: &[u8], file: &Path) -> Result<bool, DatasetError> {
    let top: Keys = json::parse(text, file, EXPECTED)?;
    let frames: FrameKeys = json::parse(text, file, EXPECTED)?;
    let keys = top.keys().chain(frames.frames.iter().flat_map(Keys::keys));
    Ok(dialect(keys).is_some())
}
