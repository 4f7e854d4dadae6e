//! COLMAP models: `cameras`, `images` and `points3D`, binary or text, in `sparse/0` and the
//! like beside `images`.
//!
//! Poses are world-to-camera, a quaternion and a translation, with OpenCV camera axes; scale
//! and axes of the world mean nothing. So it is turned and scaled: captures that look forward
//! as those of LLFF are, others so that the cameras stand upright around the origin and see
//! their points at a median depth of 1.

mod binary;
mod camera;
mod model;
mod photos;
mod place;
mod scene;
mod text;

use std::path::Path;

use super::capture::{unmasked, with_images};
use super::holdout::{HoldOut, kept};
use super::listing::{Frame, Listing, relative_path};
use super::{DatasetError, LoadOptions, Split};
use crate::json::escape;
use crate::pose;
use model::{Image, read_model};
use scene::Scene;

/// The convention's name in reports.
const FORMAT: &str = "colmap";

/// Whether a folder is a capture.
pub(super) fn is_capture(folder: &Path) -> bool {
    !place::models(folder).is_empty()
}

/// Reads and checks the model; of images, whether they are there.
pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let (at, several) = place::largest(folder, place::models(folder))?;
    let model = read_model(&folder.join(&at))?;
    let file = model.file.clone();
    let scene = Scene::new(&model);
    let first = relative_path(&model.images[0].name);
    let photos = photos::folder(folder, options.downscale_factor, &first)?;
    let mut notes: Vec<String> = several.into_iter().chain(photos.notes).collect();
    notes.push(scene.note);
    let frame = |(image, pose): (&Image, &[f64; 16])| -> Result<Frame, DatasetError> {
        let (name, camera) = (relative_path(&image.name), &model.cameras[&image.camera]);
        let pose = pose::from_list(pose).map_err(|problem| DatasetError::Colmap {
            file: file.clone(),
            problem: format!("the image {}: {problem}", escape(&image.name)),
        })?;
        let path = photos::path(folder, &photos.folder, &name);
        let mask = photos::mask(folder, &photos.folder, &name);
        Ok(Frame { mask, ..Frame::new(path, pose, camera.intrinsics, camera.lens) })
    };
    let frames = model.images.iter().zip(&scene.poses).map(frame).collect::<Result<_, _>>()?;
    let (frames, left_out) = with_images(folder, &file, frames, &mut notes, |_, _| {})?;
    notes.extend(photos::unregistered(folder, &photos.folder, &frames));
    notes.extend(unmasked(&frames));
    let frames = kept(frames, split, HoldOut { file: &file, every: options.hold_every })?;
    let sign = model.file.strip_prefix(folder).unwrap_or(&model.file).display().to_string();
    Ok(Listing {
        is_one_set: true,
        left_out,
        factor: Some(photos.factor),
        bounds: scene.bounds,
        reach: scene.reach,
        forward_facing: scene.forward_facing,
        own: scene.own,
        notes,
        ..Listing::new(FORMAT, sign, model.file, frames)
    })
}
