//! Record3D: `metadata` (of an unpacked `.r3d`) or `metadata.json` with `rgbd` or `rgb`.
//!
//! As nerfstudio reads it (`process_data/record3d_utils.py`): `poses` are a quaternion x, y, z, w
//! and a position for each image, `K` is the camera matrix column after column, in pixels of an
//! image of `w` and `h`. `perFrameIntrinsicCoeffs`, where it is there, has fx, fy, cx, cy for each
//! image. Images are named by their number, from 0.

use std::path::{Path, PathBuf};

use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;

use super::upright;
use crate::dataset::capture::with_images;
use crate::dataset::holdout::{HoldOut, kept};
use crate::dataset::intrinsics::Intrinsics;
use crate::dataset::listing::{Frame, Listing};
use crate::dataset::{DatasetError, LoadOptions, Split, thin};
use crate::json;
use crate::lens::Lens;
use crate::pose;

/// The convention's name in reports.
const FORMAT: &str = "record3d";
const FILES: [&str; 2] = ["metadata.json", "metadata"];
const FOLDERS: [&str; 2] = ["rgb", "rgbd"];
const HINT: &str = "export the recording from Record3D as \"EXR + RGB sequence\" or unpack its .r3d \
     file, which is a zip archive";
const EXPECTED: &str =
    "{\"K\": 9 numbers, \"w\": pixels, \"h\": pixels, \"poses\": [[qx, qy, qz, qw, x, y, z], …]}";
/// Of a video, so many frames are kept.
const MOST: usize = 600;

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct Metadata {
    #[serde(rename = "K")]
    matrix: Vec<f64>,
    w: f64,
    h: f64,
    poses: Vec<Vec<f64>>,
    #[serde(rename = "perFrameIntrinsicCoeffs")]
    own: Option<Vec<Vec<f64>>>,
}

/// Whether a folder holds metadata beside images.
pub(super) fn is_export(folder: &Path) -> bool {
    file(folder).is_some() && FOLDERS.iter().any(|name| folder.join(name).is_dir())
}

fn file(folder: &Path) -> Option<PathBuf> {
    FILES.iter().map(|name| folder.join(name)).find(|file| file.is_file())
}

pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let file = file(folder).ok_or_else(|| DatasetError::Missing(folder.to_owned()))?;
    let metadata: Metadata = json::parse(&json::read(&file)?, &file, EXPECTED)?;
    let refuse = |problem: String| DatasetError::Export { file: file.clone(), problem, hint: HINT };
    if metadata.poses.is_empty() {
        return Err(refuse("\"poses\" is empty, expected one for each image".to_owned()));
    }
    let inside = FOLDERS.iter().find(|name| folder.join(name).is_dir()).unwrap_or(&FOLDERS[0]);
    let frame = |i: usize| {
        let frame = metadata.frame(i, format!("{inside}/{i}"));
        frame.map_err(|problem| refuse(format!("pose {i}: {problem}")))
    };
    let mut frames = (0..metadata.poses.len()).map(frame).collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    if frames.len() > MOST {
        notes
            .push(format!("of {} frames of a video, {MOST} are used, evenly spread", frames.len()));
        thin(&mut frames, MOST);
    }
    let (frames, left_out) = with_images(folder, &file, frames, &mut notes, |_, _| {})?;
    let frames = kept(frames, split, HoldOut { file: &file, every: options.hold_every })?;
    let sign = file.file_name().unwrap_or_default().display().to_string();
    Ok(Listing { is_one_set: true, left_out, notes, ..Listing::new(FORMAT, sign, file, frames) })
}

impl Metadata {
    fn frame(&self, i: usize, path: String) -> Result<Frame, String> {
        let pose = &self.poses[i];
        let &[x, y, z, w, tx, ty, tz] = &pose[..] else {
            return Err(format!("{} numbers, expected 7: qx, qy, qz, qw, x, y, z", pose.len()));
        };
        let rotation = DQuat::from_xyzw(x, y, z, w);
        let length = rotation.length();
        if !(0.5..2.0).contains(&length) {
            return Err(format!("a rotation of length {length}, expected 1"));
        }
        let at = DVec3::new(tx, ty, tz);
        let pose = DMat4::from_rotation_translation(rotation.normalize(), at);
        let pose = pose::from_list(&upright(pose.transpose().to_cols_array()))
            .map_err(|problem| problem.to_string())?;
        let lens = Lens::Pinhole;
        let intrinsics = Intrinsics::from_pixels([self.w, self.h], self.pixels(i)?, &lens)?;
        Ok(Frame::new(path, pose, intrinsics, lens))
    }

    /// Focal lengths and principal point.
    fn pixels(&self, i: usize) -> Result<[f64; 4], String> {
        match (&self.matrix[..], &self.own) {
            (_, Some(own)) if !own.is_empty() => {
                let own = own.get(i).map(Vec::as_slice).unwrap_or_default();
                own.try_into().map_err(|_| {
                    format!("perFrameIntrinsicCoeffs has {} numbers for it, expected 4", own.len())
                })
            }
            (&[fx, .., fy, _, cx, cy, _], _) if self.matrix.len() == 9 => Ok([fx, fy, cx, cy]),
            (matrix, _) => Err(format!("\"K\" has {} numbers, expected 9", matrix.len())),
        }
    }
}
