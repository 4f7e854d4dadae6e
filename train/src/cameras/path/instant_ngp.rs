//! instant-ngp's camera paths, `base_cam.json`.

use std::path::Path;

use glam::{Mat3, Quat, Vec3};
use serde::Deserialize;

use super::super::CameraError;
use super::{Keyframe, checked_fov_y};
use crate::pose;

/// What is expected of a file.
pub(super) const EXPECTED: &str = "instant-ngp's {\"path\": [{\"R\": quaternion of 4 numbers, \"T\": 3 numbers, \"fov\": \
     vertical degrees}, …]}";

/// The size of a scene unit in the cube that instant-ngp renders, and where its origin is there,
/// unless a `transforms.json` says otherwise.
const SCALE: f32 = 0.33;
const OFFSET: f32 = 0.5;

#[derive(Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct CameraPath {
    path: Vec<Stop>,
    #[serde(default, rename = "loop")]
    pub(super) is_cycle: bool,
}

#[derive(Deserialize)]
#[serde(expecting = "a camera")]
struct Stop {
    /// x, y, z, w.
    #[serde(rename = "R")]
    rotation: [f32; 4],
    #[serde(rename = "T")]
    position: [f32; 3],
    fov: f64,
}

impl CameraPath {
    /// The keyframes, in the coordinates of the dataset.
    pub(super) fn keyframes(&self, file: &Path) -> Result<Vec<Keyframe>, CameraError> {
        let keyframe = |(camera, stop): (usize, &Stop)| {
            let pose = pose::from_list(&stop.pose()).map_err(|problem| CameraError::Pose {
                file: file.to_owned(),
                camera,
                problem,
            })?;
            let fov_y = checked_fov_y(stop.fov, file, camera)?;
            Ok(Keyframe { pose, fov_y, seconds: Keyframe::SECONDS })
        };
        self.path.iter().enumerate().map(keyframe).collect()
    }
}

impl Stop {
    /// From columns right, down, forwards in a cube whose axes are the dataset's y, z and x.
    fn pose(&self) -> Vec<f64> {
        let turn = Mat3::from_quat(Quat::from_array(self.rotation).normalize());
        let axes = |v: Vec3| Vec3::new(v.z, v.x, v.y);
        let (right, up, back) = (axes(turn.x_axis), -axes(turn.y_axis), -axes(turn.z_axis));
        let position = axes((Vec3::from(self.position) - OFFSET) / SCALE);
        let row = |i: usize| [right[i], up[i], back[i], position[i]].map(f64::from);
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_by_hand() {
        // instant-ngp takes a pose of a dataset to its cube by turning y and z of the camera around,
        // scaling, and moving axes: a camera at (2, 3, 1) that looks along the dataset's -z, with x
        // to its right and y upwards, has right (0, 0, 1), down (-1, 0, 0), forwards (0, -1, 0).
        let turn = Mat3::from_cols(Vec3::Z, -Vec3::X, -Vec3::Y);
        let stop = Stop {
            rotation: Quat::from_mat3(&turn).to_array(),
            position: [0.5 + 0.33 * 3.0, 0.5 + 0.33, 0.5 + 0.33 * 2.0],
            fov: 50.0,
        };
        let expected = [1., 0., 0., 2., 0., 1., 0., 3., 0., 0., 1., 1., 0., 0., 0., 1.];
        let found = stop.pose();
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
    }
}
