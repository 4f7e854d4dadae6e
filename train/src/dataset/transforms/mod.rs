//! `transforms.json` of instant-ngp and nerfstudio: one file, any lens.
//!
//! Both give camera-to-world poses with OpenGL camera axes in a world of their own,
//! which is kept: nerfstudio's `applied_transform` and `applied_scale` are in the poses
//! already, instant-ngp's `scale` and `offset` only say where its box lies. Frames are
//! sorted by `file_path`, numbers in it by their value.

mod aabb;
mod camera;
mod frames;
mod natural;
mod points;
mod splits;

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use super::capture::{unmasked, with_images};
use super::holdout::{HoldOut, kept};
use super::listing::Listing;
use super::recognise::dialect;
use super::{DatasetError, LoadOptions, Split};
use crate::json::{self, Keys};
use camera::RawCamera;
use frames::RawFrame;

/// The file's name.
pub(super) const FILE: &str = "transforms.json";

const EXPECTED: &str = "{\"fl_x\": pixels, \"w\": pixels, \"h\": pixels, \"frames\": [{\"file_path\": \"images/0001.jpg\", \
     \"transform_matrix\": 4 rows of 4 numbers}, …]}";

/// What stands beside the cameras.
#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct RawFile {
    frames: Vec<RawFrame>,
    aabb_scale: Option<f64>,
    scale: Option<f64>,
    offset: Option<Value>,
    aabb: Option<Vec<Vec<f64>>>,
    sharpness_discard_threshold: Option<f64>,
    train_filenames: Option<Vec<String>>,
    val_filenames: Option<Vec<String>>,
    test_filenames: Option<Vec<String>>,
    from_mitsuba: Option<bool>,
    white_transparent: Option<bool>,
    black_transparent: Option<bool>,
    fix_premult: Option<bool>,
    sharpen: Option<f64>,
    fisheye_crop_radius: Option<f64>,
    ply_file_path: Option<String>,
    orientation_override: Option<Value>,
}

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct RawCameras {
    frames: Vec<RawCamera>,
}

/// Reads and checks the frames of a split of `transforms.json`.
pub(super) fn list(
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let (mut listing, raw) = read(folder, FILE)?;
    let own = [(Split::Train, raw.train_filenames), (Split::Val, raw.val_filenames)];
    let lists: Vec<(Split, Vec<String>)> = own
        .into_iter()
        .chain([(Split::Test, raw.test_filenames)])
        .filter_map(|(split, names)| Some((split, names?)))
        .collect();
    if lists.is_empty() {
        let hold_out = HoldOut { file: &listing.file, every: options.hold_every };
        let frames = std::mem::take(&mut listing.frames);
        listing.frames = kept(frames, split, hold_out)?;
        listing.is_one_set = true;
    } else {
        splits::choose(&mut listing, split, &lists)?;
    }
    Ok(listing)
}

/// Reads and checks a file that holds one split.
pub(super) fn list_file(folder: &Path, name: &str) -> Result<Listing, DatasetError> {
    read(folder, name).map(|(listing, _)| listing)
}

/// All frames that have an image, in natural order.
fn read(folder: &Path, name: &str) -> Result<(Listing, RawFile), DatasetError> {
    let file = folder.join(name);
    let text = json::read(&file)?;
    let mut raw: RawFile = json::parse(&text, &file, EXPECTED)?;
    let top: RawCamera = json::parse(&text, &file, EXPECTED)?;
    let keys: Keys = json::parse(&text, &file, EXPECTED)?;
    let cameras: RawCameras = json::parse(&text, &file, EXPECTED)?;
    raw.refuse_what_cannot_be_read(&file)?;
    if raw.frames.is_empty() {
        return Err(DatasetError::NoFrames(file));
    }
    let depths = frames::depths(&raw.frames);
    let found = frames::read(&file, std::mem::take(&mut raw.frames), &top, &cameras.frames)?;
    if raw.fisheye_crop_radius.is_some() && found.iter().any(|(frame, _)| frame.is_fisheye()) {
        return Err(not_readable(&file, "fisheye_crop_radius"));
    }
    let mut notes: Vec<String> = depths.into_iter().collect();
    notes.extend(raw.orientation());
    let found = frames::sharp(found, raw.sharpness_discard_threshold, &mut notes);
    let (format, sign) = match dialect(keys.keys()) {
        Some((format, sign)) => (format, format!("{name}: {sign}")),
        None => (FILE, name.to_owned()),
    };
    let (frames, left_out) = with_images(folder, &file, found, &mut notes, |name, frame| {
        frames::find_companions(folder, name, frame);
    })?;
    let aabb = aabb::scene_box(&raw, &file)?;
    notes.extend(unmasked(&frames));
    let points = raw.ply_file_path.as_ref();
    let (bounds, reach) = match points.map(|path| points::read(folder, path, &frames)) {
        None => (None, None),
        Some((around, note)) => {
            notes.push(note);
            (around.as_ref().map(|a| a.bounds), around.and_then(|a| a.reach))
        }
    };
    let listing = Listing::new(format, sign, file, frames);
    Ok((Listing { aabb, bounds, reach, left_out, notes, ..listing }, raw))
}

impl RawFile {
    /// What changes the meaning of images or poses in a way that is not known here.
    fn refuse_what_cannot_be_read(&self, file: &Path) -> Result<(), DatasetError> {
        let is_set = |flag: Option<bool>| flag == Some(true);
        let given = [
            ("from_mitsuba", is_set(self.from_mitsuba)),
            ("white_transparent", is_set(self.white_transparent)),
            ("black_transparent", is_set(self.black_transparent)),
            ("fix_premult", is_set(self.fix_premult)),
            ("sharpen", self.sharpen.is_some_and(|amount| amount != 0.0)),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((key, _)) => Err(not_readable(file, key)),
        }
    }

    /// What to say of a world that is to be turned: it stays as it is.
    fn orientation(&self) -> Option<String> {
        let method = self.orientation_override.as_ref()?.as_str().unwrap_or("none");
        (method != "none").then(|| {
            let method = json::escape(method);
            format!("orientation_override \"{method}\" is not applied: the world stays as it is")
        })
    }
}

fn not_readable(file: &Path, key: &str) -> DatasetError {
    DatasetError::NotReadable {
        file: file.to_owned(),
        what: format!("\"{key}\""),
        hint: "apply it to the images and take it out of the file",
    }
}
