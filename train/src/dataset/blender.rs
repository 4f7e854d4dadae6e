//! The original NeRF's convention: `transforms_{train,val,test}.json` beside
//! their images.
//!
//! `camera_angle_x` is the horizontal field of view in radians, shared by all
//! frames: focal = 0.5 · width / tan(0.5 · angle) pixels, principal point in
//! the middle. `transform_matrix` is camera-to-world with OpenGL camera axes,
//! row after row. `file_path` is relative to the folder, with or without its
//! extension. `rotation` means nothing.

use std::path::{Path, PathBuf};

use pocketnerf_core::Camera;
use rayon::prelude::*;
use serde::Deserialize;

use super::recognise::dialect;
use super::{Dataset, DatasetError, Split, View, images};
use crate::json::{self, Keys};
use crate::pose;

/// The convention's name in reports.
pub(super) const FORMAT: &str = "blender";

const EXPECTED: &str = "a Blender dataset: {\"camera_angle_x\": radians, \"frames\": [{\"file_path\": \"./train/r_0\", \
     \"transform_matrix\": 4 rows of 4 numbers}, …]}";

/// What one JSON file says, checked.
#[derive(Debug)]
pub(super) struct Frames {
    /// The JSON file.
    pub(super) file: PathBuf,
    /// Horizontal field of view, radians.
    pub(super) fov_x: f32,
    /// The frames, in the file's order; at least one.
    pub(super) frames: Vec<Frame>,
}

/// One frame.
#[derive(Debug)]
pub(super) struct Frame {
    /// `file_path` with forward slashes and without `./`.
    pub(super) path: String,
    /// Camera-to-world, row after row.
    pub(super) pose: [f32; 16],
}

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

/// Reads and checks the JSON file of a split; looks at no image.
pub(super) fn read(folder: &Path, split: Split) -> Result<Frames, DatasetError> {
    let file = folder.join(file_name(split));
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
    refuse_dialects(&text, &file)?;
    if raw.frames.is_empty() {
        return Err(DatasetError::NoFrames(file));
    }
    let angle = raw.camera_angle_x.ok_or_else(|| DatasetError::NoFieldOfView(file.clone()))?;
    if !(0.01..std::f64::consts::PI).contains(&angle) {
        return Err(DatasetError::FieldOfView { file, angle });
    }
    let mut frames = Vec::with_capacity(raw.frames.len());
    for (index, frame) in raw.frames.into_iter().enumerate() {
        let path = relative_path(&frame.file_path);
        match pose::from_rows(&frame.transform_matrix) {
            Ok(pose) => frames.push(Frame { path, pose }),
            Err(problem) => {
                let name = frame.file_path;
                return Err(DatasetError::Pose { file, frame: index, name, problem });
            }
        }
    }
    Ok(Frames { file, fov_x: angle as f32, frames })
}

/// Reads a split with its images.
pub(super) fn load(folder: &Path, split: Split, factor: u32) -> Result<Dataset, DatasetError> {
    let Frames { file, fov_x, frames } = read(folder, split)?;
    let found: Vec<_> = frames.iter().map(|frame| images::find(folder, &frame.path)).collect();
    if let Some(first) = found.iter().position(Option::is_none) {
        return Err(DatasetError::MissingImage {
            image: folder.join(&frames[first].path),
            file,
            missing: found.iter().filter(|name| name.is_none()).count(),
            total: frames.len(),
        });
    }
    let names: Vec<String> = found.into_iter().flatten().collect();
    let decoded: Vec<_> = names
        .par_iter()
        .map(|name| {
            let image = images::decode(&folder.join(name))?;
            let full_size = image.size;
            image.downscaled(factor).map(|image| (full_size, image))
        })
        .collect();

    let mut views: Vec<View> = Vec::with_capacity(frames.len());
    let mut first_size = None;
    for ((name, frame), image) in names.into_iter().zip(&frames).zip(decoded) {
        // The first error in the dataset's order, whichever came first in time.
        let (size, image) = image?;
        let first_size = *first_size.get_or_insert(size);
        if size != first_size {
            let first = folder.join(&views[0].name);
            return Err(DatasetError::ImageSize {
                image: folder.join(name),
                size,
                first,
                first_size,
            });
        }
        let camera = Camera::from_fov_x(size[0], size[1], fov_x, frame.pose).downscaled(factor);
        views.push(View { name, camera, rgba: image.rgba, depth: None });
    }
    let has_alpha = views.par_iter().any(View::has_alpha);
    let source = folder.display().to_string();
    Ok(Dataset { source, format: FORMAT, split, views, has_alpha })
}

/// A file with intrinsics that this convention does not know belongs to
/// another one, and reading it as this one would be silently wrong.
fn refuse_dialects(text: &[u8], file: &Path) -> Result<(), DatasetError> {
    let top: Keys = json::parse(text, file, EXPECTED)?;
    let frames: FrameKeys = json::parse(text, file, EXPECTED)?;
    let keys = top.keys().chain(frames.frames.iter().flat_map(Keys::keys));
    dialect(keys).map_or(Ok(()), |(convention, sign)| {
        Err(DatasetError::NotSupported { path: file.to_owned(), convention, sign })
    })
}

/// Forward slashes, no `./` in front.
fn relative_path(file_path: &str) -> String {
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
