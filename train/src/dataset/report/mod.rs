//! What is in a dataset: the check report.

mod look;
mod picture;
mod shot;
mod suspicion;
mod text;

use std::path::Path;

use pocketnerf_core::Camera;
use serde::Serialize;

use super::listing::{Frame, Listing};
use super::{DatasetError, LoadOptions, Split, list};
use crate::cameras::nearest_to_axes;

use look::{camera_box, distances, scene_box, share_looking_at};
pub use picture::picture;
use shot::Shot;
pub use suspicion::Suspicion;

/// What is in a dataset. Missing or unreadable images are counted, not refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasetReport {
    /// The folder.
    pub source: String,
    /// The convention that was recognised.
    pub format: &'static str,
    /// The file, and the keys in it, by which it was recognised.
    pub recognised_by: String,
    /// Nearest and farthest depth, scene units, where the dataset says.
    pub bounds: Option<[f32; 2]>,
    /// The scene's box, smallest and largest corner: the dataset's own, the one around its
    /// points, or what the training cameras look at. Where images have alpha, training finds
    /// one that is as small as their silhouettes allow instead of the latter two.
    pub scene_box: Option<[[f32; 3]; 2]>,
    /// Whether it is the dataset's own.
    pub scene_box_given: bool,
    /// Whether it is the one around its points.
    pub scene_box_by_points: bool,
    /// Whether the cameras suit normalised device coordinates.
    pub forward_facing: bool,
    /// Whether it is trained in contracted space: photographs without alpha around or inside
    /// something, and no box of the dataset's own.
    pub has_no_end: bool,
    /// One image in so many is held out, if the dataset has no splits of its own.
    pub hold_every: Option<u32>,
    /// Images that are missing, of frames that are left out for that.
    pub images_left_out: Vec<String>,
    /// What else the user should know.
    pub notes: Vec<String>,
    /// What may be wrong, each with what to do.
    pub suspicions: Vec<Suspicion>,
    /// The splits that are there.
    pub splits: Vec<SplitReport>,
}

/// What is in one split.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplitReport {
    /// `train`, `val` or `test`.
    pub split: &'static str,
    /// Frames listed.
    pub frames: usize,
    /// Images found.
    pub images_found: usize,
    /// Images not found, as the dataset names them.
    pub images_missing: Vec<String>,
    /// Images found whose header cannot be read.
    pub images_unreadable: Vec<String>,
    /// Images whose shape is not that of their camera.
    pub images_misshapen: Vec<String>,
    /// The sizes met, in order of appearance.
    pub sizes: Vec<ImageSize>,
    /// Images with an alpha channel, their own or a file of its own.
    pub images_with_alpha: usize,
    /// Frames with a mask.
    pub masks: usize,
    /// Masks not found.
    pub masks_missing: Vec<String>,
    /// The kinds of lens met: pinhole, opencv, fisheye.
    pub lenses: Vec<&'static str>,
    /// Horizontal field of view of the first camera whose image can be read, degrees.
    pub fov_x_degrees: Option<f32>,
    /// Corners of the box around the camera positions, scene units.
    pub camera_box: [[f32; 3]; 2],
    /// The point nearest to all optical axes (least squares), scene units;
    /// none if the axes are parallel.
    pub look_at: Option<[f32; 3]>,
    /// Least and greatest distance of a camera from `look_at`, scene units.
    pub look_at_distance: Option<[f32; 2]>,
    /// Share of the cameras whose optical axes meet the scene's box.
    pub share_looking_at_box: Option<f64>,
}

/// How many images have a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ImageSize {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Number of images.
    pub images: usize,
}

/// Looks at the dataset in the folder `path`: its files of cameras and its images, of which as
/// many are decoded as is quick.
///
/// # Errors
/// As [`load`](super::load), except for what is wrong with images: that is in
/// the report.
pub fn inspect(path: &Path) -> Result<DatasetReport, DatasetError> {
    inspect_with(path, &LoadOptions::default())
}

/// The same with all options.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_with(path: &Path, options: &LoadOptions) -> Result<DatasetReport, DatasetError> {
    let listings = listings(path, options)?;
    // The training split, if there is one.
    let first = &listings[0].1;
    let scene_box = scene_box(first);
    let shots: Vec<Vec<Shot<'_>>> =
        listings.iter().map(|(split, listing)| Shot::all(*split, listing)).collect();
    let reports = listings.iter().zip(&shots);
    let splits: Vec<_> = reports
        .map(|((split, listing), shots)| inspect_split(*split, listing, shots, scene_box))
        .collect();
    let has_alpha = splits[0].images_with_alpha > 0;
    Ok(DatasetReport {
        source: path.display().to_string(),
        format: first.format,
        recognised_by: first.sign.clone(),
        bounds: first.bounds,
        scene_box,
        scene_box_given: first.aabb.is_some(),
        scene_box_by_points: first.aabb.is_none() && first.reach.is_some(),
        forward_facing: first.forward_facing,
        has_no_end: !(first.forward_facing || first.aabb.is_some() || has_alpha),
        hold_every: first.is_one_set.then_some(options.hold_every),
        images_left_out: first.left_out.clone(),
        notes: first.notes.clone(),
        suspicions: suspicion::find(&shots, first),
        splits,
    })
}

/// The splits that are there; at least one.
fn listings(path: &Path, options: &LoadOptions) -> Result<Vec<(Split, Listing)>, DatasetError> {
    let mut listings: Vec<(Split, Listing)> = Vec::new();
    let mut none = None;
    for split in Split::ALL {
        match list(path, split, options) {
            Ok(listing) => listings.push((split, listing)),
            // What is wrong with one split is no news of the others.
            Err(error @ (DatasetError::NoSplit { .. } | DatasetError::EmptySplit { .. })) => {
                none = none.or(Some(error));
            }
            Err(error) => return Err(error),
        }
    }
    match none {
        Some(none) if listings.is_empty() => Err(none),
        _ => Ok(listings),
    }
}

fn inspect_split(
    split: Split,
    listing: &Listing,
    shots: &[Shot<'_>],
    scene_box: Option<[[f32; 3]; 2]>,
) -> SplitReport {
    let Listing { frames, folder, .. } = listing;
    let poses: Vec<[f32; 16]> = frames.iter().map(|frame| frame.pose).collect();
    let look_at = nearest_to_axes(&poses);
    let masks = || frames.iter().filter_map(|frame| frame.mask.as_ref());
    let missing = masks().filter(|mask| !folder.join(&mask.path).is_file());
    let mut report = SplitReport {
        split: split.name(),
        frames: frames.len(),
        images_found: shots.iter().filter(|shot| shot.file.is_some()).count(),
        images_missing: Vec::new(),
        images_unreadable: Vec::new(),
        images_misshapen: Vec::new(),
        sizes: Vec::new(),
        images_with_alpha: 0,
        masks: masks().count(),
        masks_missing: missing.map(|mask| mask.path.clone()).collect(),
        lenses: Vec::new(),
        fov_x_degrees: None,
        camera_box: camera_box(&poses),
        look_at: look_at.map(|point| point.as_vec3().to_array()),
        look_at_distance: look_at.map(|point| distances(&poses, point)),
        share_looking_at_box: scene_box.map(|corners| share_looking_at(&poses, corners)),
    };
    for shot in shots {
        let frame = shot.frame;
        let lens = frame.lens.name();
        if !report.lenses.contains(&lens) {
            report.lenses.push(lens);
        }
        match shot.header {
            None if shot.file.is_none() => report.images_missing.push(frame.path.clone()),
            None => report.images_unreadable.push(frame.path.clone()),
            Some(header) => {
                report.count(header.size, header.alpha || frame.alpha.is_some());
                match &shot.camera {
                    Some(camera) => {
                        report.fov_x_degrees.get_or_insert_with(|| fov_x_degrees(camera, frame));
                    }
                    None => report.images_misshapen.push(frame.path.clone()),
                }
            }
        }
    }
    report
}

/// The angle between the leftmost and the rightmost ray beside the principal point.
fn fov_x_degrees(camera: &Camera, frame: &Frame) -> f32 {
    let angle = |x: f32| {
        let x = f64::from((x - camera.center[0]) / camera.focal[0]);
        let ([x, y, z], _) = frame.lens.undistort([x, 0.0]);
        x.hypot(y).atan2(z).copysign(x)
    };
    (angle(camera.width as f32) - angle(0.0)).to_degrees() as f32
}

impl DatasetReport {
    /// All that the user should know, a line each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let suspicions = self.suspicions.iter().map(|suspicion| suspicion.text.clone());
        self.notes.iter().cloned().chain(suspicions).collect()
    }
}

impl SplitReport {
    /// As [`Dataset::pixels_across`](super::Dataset::pixels_across).
    #[must_use]
    pub fn pixels_across(&self) -> f32 {
        super::pixels_across(self.sizes.iter().map(|s| ([s.width, s.height], s.images)))
    }

    fn count(&mut self, [width, height]: [u32; 2], alpha: bool) {
        self.images_with_alpha += usize::from(alpha);
        let known = self.sizes.iter_mut().find(|s| (s.width, s.height) == (width, height));
        match known {
            Some(size) => size.images += 1,
            None => self.sizes.push(ImageSize { width, height, images: 1 }),
        }
    }
}
