//! 3d Scanner App, "All Data": `frame_00000.json` beside `frame_00000.jpg`, and so on.
//!
//! `cameraPoseARFrame` is ARKit's camera-to-world matrix and `intrinsics` its camera matrix, both
//! row after row, in pixels of the image as the sensor has it. The app writes a JSON file for every
//! frame, but an image for some only.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::upright;
use crate::dataset::holdout::{HoldOut, kept};
use crate::dataset::intrinsics::Intrinsics;
use crate::dataset::listing::{Frame, Listing};
use crate::dataset::{DatasetError, LoadOptions, Split, images};
use crate::json;
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
const FORMAT: &str = "3d-scanner-app";
const HINT: &str = "export the scan from 3d Scanner App as \"All Data\"";
const EXPECTED: &str = "{\"cameraPoseARFrame\": 16 numbers, \"intrinsics\": 9 numbers}";
/// A principal point is not farther from the middle than this part of a side: else the image is
/// not the one that was measured.
const FARTHEST: f64 = 0.15;

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct RawFrame {
    #[serde(rename = "cameraPoseARFrame")]
    pose: Vec<f64>,
    intrinsics: Vec<f64>,
}

/// Whether a folder holds `frame_*.json` with a camera of ARKit.
pub(super) fn is_export(folder: &Path) -> bool {
    let first = names(folder).into_iter().flatten().next();
    let text = first.and_then(|name| json::read(&folder.join(name)).ok()).unwrap_or_default();
    let key = b"\"cameraPoseARFrame\"";
    text.windows(key.len()).any(|part| part == key)
}

fn names(folder: &Path) -> Result<Vec<String>, DatasetError> {
    let mut names = images::names(folder, &["json"])?;
    names.retain(|name| name.starts_with("frame_"));
    Ok(names)
}

pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let names = names(folder)?;
    let photo = |name: &String| images::find(folder, name.strip_suffix(".json")?);
    let photos = names.iter().filter_map(|name| Some((folder.join(name), photo(name)?)));
    let frame = |(file, photo): (PathBuf, String)| {
        let raw: RawFrame = json::parse(&json::read(&file)?, &file, EXPECTED)?;
        let frame = raw.frame(images::size(&folder.join(&photo)), photo);
        frame.map_err(|problem| DatasetError::Export { file, problem, hint: HINT })
    };
    let frames = photos.map(frame).collect::<Result<Vec<_>, _>>()?;
    let refuse = |problem| DatasetError::Export { file: folder.to_owned(), problem, hint: HINT };
    if frames.is_empty() {
        return Err(refuse(format!("{} frames, but no image of any", names.len())));
    }
    let sign = format!("{}: it has cameraPoseARFrame", names[0]);
    let notes = vec![format!("{} of {} frames have an image", frames.len(), names.len())];
    let frames = kept(frames, split, HoldOut { file: folder, every: options.hold_every })?;
    let listing = Listing::new(FORMAT, sign, folder.to_owned(), frames);
    Ok(Listing { is_one_set: true, notes, ..listing })
}

impl RawFrame {
    /// An image without a size cannot be read, which is said when it is decoded.
    fn frame(&self, size: Option<[u32; 2]>, path: String) -> Result<Frame, String> {
        let pose: [f64; 16] = self.pose[..].try_into().map_err(|_| {
            format!("cameraPoseARFrame has {} numbers, expected 16", self.pose.len())
        })?;
        let pose = pose::from_list(&upright(pose)).map_err(|problem| problem.to_string())?;
        let &[fx, _, cx, _, fy, cy, ..] = &self.intrinsics[..] else {
            return Err(format!("intrinsics has {} numbers, expected 9", self.intrinsics.len()));
        };
        let [width, height] = size.map_or([2.0 * cx, 2.0 * cy], |size| size.map(f64::from));
        let lens = Lens::Pinhole;
        let intrinsics = Intrinsics::from_pixels([width, height], [fx, fy, cx, cy], &lens)?;
        let is_off = |c: f64, side: f64| (c - 0.5 * side).abs() > FARTHEST * side;
        if is_off(cx, width) || is_off(cy, height) {
            return Err(format!(
                "its principal point is at ({cx}, {cy}), but its image has {width}x{height} pixels: \
                 turned or made smaller"
            ));
        }
        Ok(Frame::new(path, pose, intrinsics, lens))
    }
}
