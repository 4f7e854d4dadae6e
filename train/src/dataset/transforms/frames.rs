//! The frames of `transforms.json`.

use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::camera::{self, RawCamera, Refused};
use super::natural;
use crate::dataset::DatasetError;
use crate::dataset::listing::{Frame, Mask, relative_path};
use crate::pose;

/// What a frame says, its camera apart.
#[derive(Deserialize)]
#[serde(expecting = "a frame")]
pub(super) struct RawFrame {
    file_path: String,
    transform_matrix: Option<Vec<Vec<f64>>>,
    transform_matrix_start: Option<IgnoredAny>,
    mask_path: Option<String>,
    depth_file_path: Option<IgnoredAny>,
    depth_path: Option<IgnoredAny>,
    sharpness: Option<f64>,
}

/// A frame, and how sharp its image is.
pub(super) type Graded = (Frame, Option<f64>);

/// The frames, checked, in natural order.
pub(super) fn read(
    file: &Path,
    raw: Vec<RawFrame>,
    top: &RawCamera,
    cameras: &[RawCamera],
) -> Result<Vec<Graded>, DatasetError> {
    let mut frames = Vec::with_capacity(raw.len());
    for (index, (frame, own)) in raw.into_iter().zip(cameras).enumerate() {
        let path = relative_path(&frame.file_path);
        let (name, at) = (frame.file_path, file.to_owned());
        let Some(rows) = frame.transform_matrix else {
            return Err(match frame.transform_matrix_start {
                Some(_) => not_readable(file, "\"transform_matrix_start\"".to_owned()),
                None => {
                    let problem = "no transform_matrix, expected 4 rows of 4 numbers".to_owned();
                    DatasetError::Camera { file: at, frame: index, name, problem }
                }
            });
        };
        let pose = match pose::from_rows(&rows) {
            Ok(pose) => pose,
            Err(problem) => {
                return Err(DatasetError::Pose { file: at, frame: index, name, problem });
            }
        };
        let camera = camera::intrinsics(top, own)
            .and_then(|intrinsics| Ok((intrinsics, camera::lens(top, own)?)));
        let (intrinsics, lens) = camera.map_err(|refused| match refused {
            Refused::NotReadable(what) => not_readable(file, what),
            Refused::Problem(problem) => {
                DatasetError::Camera { file: at, frame: index, name, problem }
            }
        })?;
        let mask = frame.mask_path.map(|path| {
            let path = relative_path(&path);
            Mask { path, black_counts: false, may_be_larger: false }
        });
        let frame_ = Frame { mask, ..Frame::new(path, pose, intrinsics, lens) };
        frames.push((frame_, frame.sharpness));
    }
    frames.sort_by(|(a, _), (b, _)| natural::compare(&a.path, &b.path));
    Ok(frames)
}

fn not_readable(file: &Path, what: String) -> DatasetError {
    let moves = ["\"rolling_shutter\"", "\"transform_matrix_start\""].contains(&what.as_str());
    let hint = match moves {
        true => {
            "the camera moved while it took images row after row: give one transform_matrix each"
        }
        false => "undistort the images to a pinhole or OpenCV camera first",
    };
    DatasetError::NotReadable { file: file.to_owned(), what, hint }
}

/// What to say where frames have depths.
pub(super) fn depths(raw: &[RawFrame]) -> Option<String> {
    let with = |frame: &&RawFrame| frame.depth_file_path.is_some() || frame.depth_path.is_some();
    let count = raw.iter().filter(with).count();
    (count > 0).then(|| format!("{count} frames have depths: they are not used"))
}

/// Frames that are sharper than this part of the mean of their neighbours, three on
/// both sides and themselves.
pub(super) fn sharp(
    frames: Vec<Graded>,
    threshold: Option<f64>,
    notes: &mut Vec<String>,
) -> Vec<Frame> {
    const AROUND: usize = 3;
    let all = frames.len();
    let grades: Vec<Option<f64>> = frames.iter().map(|(_, sharpness)| *sharpness).collect();
    let is_sharp = |i: usize| {
        let (Some(own), Some(threshold)) = (grades[i], threshold) else { return true };
        let around = &grades[i.saturating_sub(AROUND)..(i + AROUND + 1).min(all)];
        let known = around.iter().flatten();
        own > threshold * known.clone().sum::<f64>() / known.count() as f64
    };
    let kept = frames.into_iter().enumerate().filter(|(i, _)| is_sharp(*i));
    let kept: Vec<Frame> = kept.map(|(_, (frame, _))| frame).collect();
    if kept.len() < all {
        let blurred = all - kept.len();
        notes.push(format!(
            "{blurred} of {all} frames are blurred (sharpness_discard_threshold): they are left out"
        ));
    }
    kept
}

/// Files that belong to an image by their names: instant-ngp's `dynamic_mask_NAME.png`,
/// where what is not black is ignored, and `FILE.alpha.EXTENSION`.
pub(super) fn find_companions(folder: &Path, name: &str, frame: &mut Frame) {
    let (parent, file) = name.rsplit_once('/').map_or(("", name), |(parent, file)| (parent, file));
    let (stem, extension) = file.rsplit_once('.').unwrap_or((file, ""));
    let beside = |file: String| {
        let path = if parent.is_empty() { file } else { format!("{parent}/{file}") };
        folder.join(&path).is_file().then_some(path)
    };
    if frame.mask.is_none() {
        let path = beside(format!("dynamic_mask_{stem}.png"));
        frame.mask = path.map(|path| Mask { path, black_counts: true, may_be_larger: false });
    }
    frame.alpha = beside(format!("{file}.alpha.{extension}"))
        .or_else(|| beside(format!("{stem}.alpha.{extension}")));
}
