//! nerfstudio's camera paths, `camera_path.json`.

use std::path::Path;

use serde::Deserialize;

use super::super::CameraError;
use super::{
    CameraPath, Keyframe, Timing, Wanted, checked, checked_fov_y, from_fov_y, interpolated, size_or,
};
use crate::{json, pose};

/// What is expected of a file.
pub(super) const EXPECTED: &str = "nerfstudio's {\"camera_path\": [{\"camera_to_world\": 16 numbers, \"fov\": vertical degrees}, …], \
     \"render_width\": pixels, \"render_height\": pixels}, or \"keyframes\": [{\"matrix\": 16 numbers, \"fov\": …}, …] in \
     place of \"camera_path\"";

#[derive(Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct File {
    #[serde(default)]
    camera_path: Vec<Frame>,
    #[serde(default)]
    keyframes: Vec<Stop>,
    default_transition_sec: Option<f64>,
    fps: Option<f64>,
    seconds: Option<f64>,
    #[serde(default)]
    is_cycle: bool,
    render_width: Option<f64>,
    render_height: Option<f64>,
    camera_type: Option<String>,
}

#[derive(Deserialize)]
#[serde(expecting = "a camera")]
struct Frame {
    camera_to_world: Vec<f64>,
    fov: f64,
}

#[derive(Deserialize)]
#[serde(expecting = "a keyframe")]
struct Stop {
    matrix: Matrix,
    fov: f64,
    override_transition_enabled: Option<bool>,
    override_transition_sec: Option<f64>,
}

/// Row after row; as text, as older versions write it, column after column.
#[derive(Deserialize)]
#[serde(untagged, expecting = "16 numbers")]
enum Matrix {
    Rows(Vec<f64>),
    Columns(String),
}

/// The cameras of a file.
pub(super) fn read(path: File, file: &Path, wanted: Wanted) -> Result<CameraPath, CameraError> {
    if let Some(found) = path.camera_type.filter(|lens| lens != "perspective") {
        return Err(CameraError::Lens { file: file.to_owned(), found });
    }
    let own = (path.render_width, path.render_height);
    if path.camera_path.is_empty() && !path.keyframes.is_empty() {
        let usual = path.default_transition_sec.unwrap_or(Keyframe::SECONDS);
        let keyframe = |(index, keyframe): (usize, &Stop)| {
            let is_given = keyframe.override_transition_enabled == Some(true);
            let seconds = keyframe.override_transition_sec.filter(|_| is_given);
            Ok(Keyframe {
                pose: keyframe.matrix.pose(file, index)?,
                fov_y: checked_fov_y(keyframe.fov, file, index)?,
                seconds: seconds.unwrap_or(usual),
            })
        };
        let keyframes: Result<Vec<_>, CameraError> =
            path.keyframes.iter().enumerate().map(keyframe).collect();
        let timing = Timing { is_cycle: path.is_cycle, fps: path.fps, seconds: path.seconds };
        return interpolated(keyframes?, timing, own, file, wanted);
    }
    let size = size_or(wanted.size, own.0, own.1, file)?;
    let camera = |(index, camera): (usize, &Frame)| {
        let pose = checked(pose::from_list(&camera.camera_to_world), file, index)?;
        Ok(from_fov_y(size, checked_fov_y(camera.fov, file, index)?, pose))
    };
    let cameras: Result<Vec<_>, CameraError> =
        path.camera_path.iter().enumerate().map(camera).collect();
    Ok(CameraPath { cameras: cameras?, fps: wanted.fps.or(path.fps) })
}

impl Matrix {
    fn pose(&self, file: &Path, camera: usize) -> Result<[f32; 16], CameraError> {
        let rows = match self {
            Self::Rows(rows) => rows.clone(),
            Self::Columns(text) => {
                let columns: Vec<f64> =
                    json::parse(text.as_bytes(), file, "a \"matrix\" of 16 numbers")?;
                let n = columns.len();
                (0..n).map(|i| columns[if n == 16 { i % 4 * 4 + i / 4 } else { i }]).collect()
            }
        };
        checked(pose::from_list(&rows), file, camera)
    }
}
