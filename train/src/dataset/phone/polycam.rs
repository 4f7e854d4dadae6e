//! Polycam's raw data: `keyframes` with a JSON file of the camera for each image.
//!
//! As nerfstudio reads it (`process_data/polycam_utils.py`): t_00 to t_23 are the camera-to-world
//! matrix, three rows of four; `fx fy cx cy` are pixels of an image of `width` and `height`.
//! `corrected_images` with `corrected_cameras` are what Polycam has undistorted and aligned once
//! more; `images` with `cameras` are the phone's own. Undistorted images may have black edges.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::upright;
use crate::dataset::capture::with_images;
use crate::dataset::holdout::{HoldOut, kept};
use crate::dataset::intrinsics::Intrinsics;
use crate::dataset::listing::{Frame, Listing};
use crate::dataset::{DatasetError, LoadOptions, Split, images};
use crate::json;
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
const FORMAT: &str = "polycam";
const KEYFRAMES: &str = "keyframes";
/// Cameras and images: corrected ones, and the phone's own.
const FOLDERS: [[&str; 2]; 2] = [["corrected_cameras", "corrected_images"], ["cameras", "images"]];
const HINT: &str =
    "turn on Developer Mode in Polycam's settings, process the capture, and export its Raw Data";
const EXPECTED: &str = "{\"t_00\": number, … \"t_23\": number, \"fx\": pixels, \"fy\": pixels, \
     \"cx\": pixels, \"cy\": pixels, \"width\": pixels, \"height\": pixels}";
/// Images of a smaller `blur_score` are left out, as nerfstudio does.
const BLURRED: f64 = 25.0;
/// This part of the width is what the edges of undistorted images may lack, 16 of 1024 pixels;
/// nerfstudio cuts off 15.
const EDGE: f64 = 1.0 / 64.0;

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct RawCamera {
    t_00: f64,
    t_01: f64,
    t_02: f64,
    t_03: f64,
    t_10: f64,
    t_11: f64,
    t_12: f64,
    t_13: f64,
    t_20: f64,
    t_21: f64,
    t_22: f64,
    t_23: f64,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    width: f64,
    height: f64,
    blur_score: Option<f64>,
}

/// Whether a folder holds `keyframes`, or is it.
pub(super) fn is_export(folder: &Path) -> bool {
    folder.join(KEYFRAMES).is_dir() || folder.join(FOLDERS[0][0]).is_dir()
}

pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let inside = if folder.join(KEYFRAMES).is_dir() { "keyframes/" } else { "" };
    let at = |name: &str| folder.join(format!("{inside}{name}"));
    let is_there = |[cameras, images]: &&[&str; 2]| at(cameras).is_dir() && at(images).is_dir();
    let Some([cameras, photos]) = FOLDERS.iter().find(is_there) else {
        let problem = "no images with cameras, expected corrected_images and corrected_cameras";
        return Err(refusal(at(""), problem.to_owned()));
    };
    let file = at(cameras);
    let names = images::names(&file, &["json"])?;
    if names.is_empty() {
        let problem = "no camera, expected a JSON file for each image".to_owned();
        return Err(refusal(file, problem));
    }
    let is_corrected = *cameras == FOLDERS[0][0];
    let frame = |name: &String| -> Result<(Frame, f64), DatasetError> {
        let stem = name.strip_suffix(".json").unwrap_or(name);
        let raw = RawCamera::read(&file.join(name))?;
        let blur = raw.blur_score.unwrap_or(f64::INFINITY);
        let path = format!("{inside}{photos}/{stem}");
        let mut frame = raw.frame(path).map_err(|problem| refusal(file.join(name), problem))?;
        frame.edge = if is_corrected { EDGE } else { 0.0 };
        Ok((frame, blur))
    };
    let frames = names.iter().map(frame).collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    if is_corrected {
        notes.push("the edges of undistorted images may be black: they do not count".to_owned());
    } else {
        notes.push(format!(
            "no corrected_cameras: poses are as the phone tracked them; for better ones, {HINT}"
        ));
    }
    let frames = sharp(frames, &mut notes);
    let (frames, left_out) = with_images(folder, &file, frames, &mut notes, |_, _| {})?;
    let frames = kept(frames, split, HoldOut { file: &file, every: options.hold_every })?;
    let sign = format!("{inside}{cameras}");
    Ok(Listing { is_one_set: true, left_out, notes, ..Listing::new(FORMAT, sign, file, frames) })
}

fn refusal(file: PathBuf, problem: String) -> DatasetError {
    DatasetError::Export { file, problem, hint: HINT }
}

/// Frames that are not blurred; all of them where that leaves none.
fn sharp(frames: Vec<(Frame, f64)>, notes: &mut Vec<String>) -> Vec<Frame> {
    let all = frames.len();
    let is_sharp = |(_, score): &(Frame, f64)| *score >= BLURRED;
    let any = frames.iter().any(is_sharp);
    let frames = frames.into_iter().filter(|frame| !any || is_sharp(frame));
    let kept: Vec<Frame> = frames.map(|(frame, _)| frame).collect();
    if kept.len() < all {
        notes.push(format!(
            "{} of {all} images are blurred (blur_score below {BLURRED}): they are left out",
            all - kept.len()
        ));
    }
    kept
}

impl RawCamera {
    fn read(file: &Path) -> Result<Self, DatasetError> {
        Ok(json::parse(&json::read(file)?, file, EXPECTED)?)
    }

    fn frame(&self, path: String) -> Result<Frame, String> {
        let rows = [
            [self.t_00, self.t_01, self.t_02, self.t_03],
            [self.t_10, self.t_11, self.t_12, self.t_13],
            [self.t_20, self.t_21, self.t_22, self.t_23],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let pose = upright(std::array::from_fn(|i| rows[i / 4][i % 4]));
        let pose = pose::from_list(&pose).map_err(|problem| problem.to_string())?;
        let pixels = [self.fx, self.fy, self.cx, self.cy];
        let lens = Lens::Pinhole;
        let intrinsics = Intrinsics::from_pixels([self.width, self.height], pixels, &lens)?;
        Ok(Frame::new(path, pose, intrinsics, lens))
    }
}
