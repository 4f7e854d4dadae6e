//! What is in a dataset: the check report.

use std::fmt;
use std::path::Path;

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::{DatasetError, LoadOptions, Split, decode, images, list};

/// What is in a dataset. Missing or unreadable images are counted, not refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasetReport {
    /// The folder.
    pub source: String,
    /// The convention that was recognised.
    pub format: &'static str,
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
    /// The sizes met, in order of appearance; a good dataset has one.
    pub sizes: Vec<ImageSize>,
    /// Images with an alpha channel.
    pub images_with_alpha: usize,
    /// Horizontal field of view in degrees.
    pub fov_x_degrees: f32,
    /// Corners of the box around the camera positions, scene units.
    pub camera_box: [[f32; 3]; 2],
    /// The point nearest to all optical axes (least squares), scene units;
    /// none if the axes are parallel.
    pub look_at: Option<[f32; 3]>,
    /// Least and greatest distance of a camera from `look_at`, scene units.
    pub look_at_distance: Option<[f32; 2]>,
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

/// Looks at the dataset in the folder `path`: its JSON files and the headers
/// of its images.
///
/// # Errors
/// As [`load`](super::load), except for what is wrong with images: that is in
/// the report.
pub fn inspect(path: &Path) -> Result<DatasetReport, DatasetError> {
    let options = LoadOptions::default();
    let mut found = None;
    let mut splits = Vec::new();
    for split in Split::ALL {
        match list(path, split, &options) {
            Ok(listing) => {
                found = Some(listing.format);
                splits.push(inspect_split(path, split, &listing));
            }
            Err(DatasetError::NoSplit { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    let source = path.display().to_string();
    Ok(DatasetReport { source, format: found.unwrap_or_default(), splits })
}

fn inspect_split(folder: &Path, split: Split, listing: &super::listing::Listing) -> SplitReport {
    let frames = &listing.frames;
    let headers: Vec<_> = frames
        .par_iter()
        .map(|frame| {
            images::find(folder, &frame.path).map(|name| images::header(&folder.join(name)))
        })
        .collect();
    let poses: Vec<[f32; 16]> = frames.iter().map(|frame| frame.pose).collect();
    let look_at = nearest_to_axes(&poses);
    let mut report = SplitReport {
        split: split.name(),
        frames: frames.len(),
        images_found: headers.iter().flatten().count(),
        images_missing: Vec::new(),
        images_unreadable: Vec::new(),
        sizes: Vec::new(),
        images_with_alpha: 0,
        fov_x_degrees: 0.0,
        camera_box: camera_box(&poses),
        look_at: look_at.map(|point| point.as_vec3().to_array()),
        look_at_distance: look_at.map(|point| distances(&poses, point)),
    };
    for (frame, header) in frames.iter().zip(headers) {
        match header {
            None => report.images_missing.push(frame.path.clone()),
            Some(None) => report.images_unreadable.push(frame.path.clone()),
            Some(Some((size, alpha))) => {
                report.count(size, alpha);
                if let Ok(camera) = decode::camera(folder, &frame.path, frame, size) {
                    report.fov_x_degrees =
                        2.0 * (0.5 * size[0] as f32 / camera.focal[0]).atan().to_degrees();
                }
            }
        }
    }
    report
}

impl SplitReport {
    fn count(&mut self, [width, height]: [u32; 2], alpha: bool) {
        self.images_with_alpha += usize::from(alpha);
        let known = self.sizes.iter_mut().find(|s| (s.width, s.height) == (width, height));
        match known {
            Some(size) => size.images += 1,
            None => self.sizes.push(ImageSize { width, height, images: 1 }),
        }
    }
}

fn position(pose: &[f32; 16]) -> DVec3 {
    DVec3::new(pose[3].into(), pose[7].into(), pose[11].into())
}

fn camera_box(poses: &[[f32; 16]]) -> [[f32; 3]; 2] {
    let corner = |pick: fn(DVec3, DVec3) -> DVec3| {
        let point = poses.iter().map(position).reduce(pick).unwrap_or_default();
        point.as_vec3().to_array()
    };
    [corner(DVec3::min), corner(DVec3::max)]
}

fn distances(poses: &[[f32; 16]], point: DVec3) -> [f32; 2] {
    let of = poses.iter().map(|pose| position(pose).distance(point) as f32);
    [of.clone().fold(f32::INFINITY, f32::min), of.fold(0.0, f32::max)]
}

/// The point with the least sum of squared distances to the optical axes:
/// Σ (I − d dᵀ) p = Σ (I − d dᵀ) o.
pub(crate) fn nearest_to_axes(poses: &[[f32; 16]]) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for pose in poses {
        let axis = DVec3::new(pose[2].into(), pose[6].into(), pose[10].into()).normalize();
        let across =
            DMat3::IDENTITY - DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        matrix += across;
        right += across * position(pose);
    }
    // The determinant of the mean is 0 for parallel axes, at most 8/27.
    let n = poses.len() as f64;
    let parallel = (matrix * (1.0 / n)).determinant() < 1e-9;
    (!parallel).then(|| matrix.inverse() * right)
}

impl fmt::Display for DatasetReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "dataset   {}", crate::json::escape(&self.source))?;
        write!(f, "format    {} (camera-to-world, x right, y up, looking along -z)", self.format)?;
        self.splits.iter().try_for_each(|split| write!(f, "\n{split}"))
    }
}

impl fmt::Display for SplitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<9} {} frames, {} images found", self.split, self.frames, self.images_found)?;
        for (names, what) in
            [(&self.images_missing, "missing"), (&self.images_unreadable, "unreadable")]
        {
            if let Some(first) = names.first() {
                write!(f, ", {} {what} (first: {})", names.len(), crate::json::escape(first))?;
            }
        }
        for size in &self.sizes {
            write!(f, "\n          {}x{} pixels: {} images", size.width, size.height, size.images)?;
        }
        let [low, high] = self.camera_box;
        write!(f, "\n          alpha channel in {} images", self.images_with_alpha)?;
        write!(f, "\n          field of view {:.2} degrees wide", self.fov_x_degrees)?;
        write!(f, "\n          cameras from {} to {}", point(low), point(high))?;
        if let (Some(at), Some([near, far])) = (self.look_at, self.look_at_distance) {
            let at = point(at);
            write!(f, "\n          looking at {at}, from {near:.3} to {far:.3} away")?;
        }
        Ok(())
    }
}

fn point([x, y, z]: [f32; 3]) -> String {
    // Adding 0 after rounding to what is shown turns -0.000 into 0.000.
    let [x, y, z] = [x, y, z].map(|v| (v * 1e3).round() / 1e3 + 0.0);
    format!("({x:.3}, {y:.3}, {z:.3})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_core::Camera;

    #[test]
    fn axes_that_meet_and_axes_that_do_not() {
        let target = [1.0, 2.0, 3.0];
        let poses: Vec<_> = [[5.0, 2.0, 3.0], [1.0, 9.0, 3.5], [0.0, 0.0, 8.0]]
            .into_iter()
            .map(|eye| Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
            .collect();
        let point = nearest_to_axes(&poses).unwrap();
        assert!(point.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-5, "{point}");
        assert_eq!(camera_box(&poses), [[0.0, 0.0, 3.0], [5.0, 9.0, 8.0]]);
        assert_eq!(nearest_to_axes(&poses[..1]), None);
    }
}
