//! Camera paths from files: nerfstudio's `camera_path.json`, instant-ngp's `base_cam.json`, and
//! anything in the manner of `transforms.json`.

mod instant_ngp;
mod nerfstudio;
#[cfg(test)]
mod tests;

use std::path::Path;

use pocketnerf_core::Camera;
use pocketnerf_core::camera::{Keyframe, KeyframePath};
use serde::Deserialize;

use super::CameraError;
use crate::json::{self, Keys};
use crate::pose;

/// Pictures at most: an hour.
const MOST_PICTURES: f64 = 108_000.0;

const TRANSFORMS: &str =
    "{\"camera_angle_x\": radians, \"frames\": [{\"transform_matrix\": 4 rows of 4 numbers}, …]}";

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct TransformsPath {
    camera_angle_x: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    frames: Vec<TransformsFrame>,
}

#[derive(Deserialize)]
#[serde(expecting = "a frame")]
struct TransformsFrame {
    transform_matrix: Vec<Vec<f64>>,
}

/// The cameras of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// One a picture, in the dataset's coordinates.
    pub cameras: Vec<Camera>,
    /// Pictures a second, where the caller or the file says it.
    pub fps: Option<f64>,
}

/// What the caller wants of a path; each goes before the file's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Pictures a second, for paths of keyframes.
    pub fps: Option<f64>,
    /// How long a path of keyframes takes.
    pub seconds: Option<f64>,
}

/// Reads a camera path. Four kinds are recognised by their keys:
///
/// * `camera_path`: nerfstudio's; `fov` is vertical, in degrees; poses are
///   taken as scene units.
/// * `keyframes` alone: nerfstudio's too, from which cameras are interpolated, as many as `fps` and
///   `seconds`, or the time from each to the next, ask for.
/// * `path`: instant-ngp's keyframes, in its cube, of a dataset of the usual scale and offset.
/// * `frames`: as in `transforms.json`, with `camera_angle_x`, horizontal, in
///   radians, and perhaps `w` and `h`; a lens other than a pinhole is left out.
///
/// # Errors
/// One line: the file, what was found and what was expected.
pub fn camera_path(file: &Path, wanted: Wanted) -> Result<CameraPath, CameraError> {
    let text = json::read(file)?;
    let keys: Keys = json::parse(&text, file, "a JSON object with a camera path")?;
    let has = |key| keys.contains_key(key);
    let path = if has("camera_path") || has("keyframes") {
        nerfstudio::read(json::parse(&text, file, nerfstudio::EXPECTED)?, file, wanted)
    } else if has("path") {
        let path: instant_ngp::CameraPath = json::parse(&text, file, instant_ngp::EXPECTED)?;
        let timing = Timing { is_cycle: path.is_cycle, fps: None, seconds: None };
        interpolated(path.keyframes(file)?, timing, (None, None), file, wanted)
    } else if has("frames") {
        let cameras = transforms(json::parse(&text, file, TRANSFORMS)?, file, wanted.size)?;
        Ok(CameraPath { cameras, fps: wanted.fps })
    } else {
        return Err(CameraError::NotAPath(file.to_owned()));
    }?;
    if path.cameras.is_empty() { Err(CameraError::Empty(file.to_owned())) } else { Ok(path) }
}

/// How a file says that its keyframes are passed.
#[derive(Clone, Copy, Debug)]
struct Timing {
    is_cycle: bool,
    fps: Option<f64>,
    seconds: Option<f64>,
}

/// The cameras between keyframes.
fn interpolated(
    mut keyframes: Vec<Keyframe>,
    timing: Timing,
    (width, height): (Option<f64>, Option<f64>),
    file: &Path,
    wanted: Wanted,
) -> Result<CameraPath, CameraError> {
    if keyframes.is_empty() {
        return Err(CameraError::Empty(file.to_owned()));
    }
    let [width, height] = size_or(wanted.size, width, height, file)?;
    let given = wanted.fps.or(timing.fps);
    let (is_cycle, fps) = (timing.is_cycle, given.unwrap_or(KeyframePath::FPS));
    let own = KeyframePath { keyframes: &keyframes, is_cycle, fps }.seconds();
    if let Some(seconds) = wanted.seconds.or(timing.seconds).filter(|_| own > 0.0) {
        keyframes.iter_mut().for_each(|keyframe| keyframe.seconds *= seconds / own);
    }
    let path = KeyframePath { keyframes: &keyframes, is_cycle, fps };
    let (seconds, pictures) = (path.seconds(), path.seconds() * fps);
    let sound = keyframes.iter().all(|keyframe| keyframe.seconds > 0.0) && pictures >= 0.0;
    if !sound || pictures > MOST_PICTURES {
        let found = format!("{seconds} seconds of {fps} pictures");
        return Err(CameraError::Timing { file: file.to_owned(), found });
    }
    let camera = |(pose, fov_y)| from_fov_y([width, height], fov_y, pose);
    Ok(CameraPath { cameras: path.pictures().map(camera).collect(), fps: given })
}

fn from_fov_y([width, height]: [u32; 2], fov_y: f64, pose: [f32; 16]) -> Camera {
    let focal = (0.5 * f64::from(height) / (0.5 * fov_y.to_radians()).tan()) as f32;
    Camera {
        width,
        height,
        focal: [focal, focal],
        center: [0.5 * width as f32, 0.5 * height as f32],
        camera_to_world: pose,
    }
}

/// A vertical field of view, degrees.
fn checked_fov_y(fov: f64, file: &Path, camera: usize) -> Result<f64, CameraError> {
    let expected = "a vertical angle in degrees from 0.5 to below 180";
    field_of_view(Some(fov), 0.5..180.0, expected, file, camera)
}

fn transforms(
    path: TransformsPath,
    file: &Path,
    size: Option<[u32; 2]>,
) -> Result<Vec<Camera>, CameraError> {
    let [width, height] = size_or(size, path.w, path.h, file)?;
    let expected = "\"camera_angle_x\" in radians from 0.01 to below pi";
    let angles = 0.01..std::f64::consts::PI;
    let fov_x = field_of_view(path.camera_angle_x, angles, expected, file, 0)? as f32;
    let camera = |(index, frame): (usize, &TransformsFrame)| {
        let pose = checked(pose::from_rows(&frame.transform_matrix), file, index)?;
        Ok(Camera::from_fov_x(width, height, fov_x, pose))
    };
    path.frames.iter().enumerate().map(camera).collect()
}

fn checked(
    pose: Result<[f32; 16], pose::PoseProblem>,
    file: &Path,
    camera: usize,
) -> Result<[f32; 16], CameraError> {
    pose.map_err(|problem| CameraError::Pose { file: file.to_owned(), camera, problem })
}

fn field_of_view(
    angle: Option<f64>,
    range: std::ops::Range<f64>,
    expected: &'static str,
    file: &Path,
    camera: usize,
) -> Result<f64, CameraError> {
    angle.filter(|angle| range.contains(angle)).ok_or_else(|| CameraError::FieldOfView {
        file: file.to_owned(),
        camera,
        found: angle.map_or_else(|| "missing".to_owned(), |angle| angle.to_string()),
        expected,
    })
}

/// The requested size, or the file's.
fn size_or(
    asked: Option<[u32; 2]>,
    width: Option<f64>,
    height: Option<f64>,
    file: &Path,
) -> Result<[u32; 2], CameraError> {
    let own = width.zip(height).map(|(width, height)| [width, height]);
    let size = asked.map(|size| size.map(f64::from)).or(own);
    match size {
        Some(size) if size.iter().all(|side| (1.0..=65536.0).contains(side)) => {
            Ok(size.map(|side| side as u32))
        }
        _ => {
            let found = size.map_or_else(|| "missing".to_owned(), |[w, h]| format!("{w}x{h}"));
            Err(CameraError::Size { file: file.to_owned(), found })
        }
    }
}
