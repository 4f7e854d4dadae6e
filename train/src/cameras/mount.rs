//! How a camera is corrected.
//!
//! It turns about a point ahead of it, where the scene is, and moves; both along its own axes. So
//! each number does something of its own to the picture: turned about itself, a camera would have
//! to move at the same time to keep what it sees in place, and pictures hardly tell how much of
//! both (what Park et al. 2023, "CamP", cure by a preconditioner).

use glam::{DMat3, DQuat, DVec3};
use pocketnerf_core::Camera;

/// Numbers of a correction: a rotation vector, radians, and a shift, units of the cameras.
pub(crate) const PER_VIEW: usize = 6;
/// Below this angle, radians, series are exact.
const SMALL: f64 = 1e-4;

/// A camera as it was given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mount {
    /// Right, up and back.
    axes: DMat3,
    eye: DVec3,
    /// From what it turns about, scene units.
    distance: f64,
    /// Length of a shift of 1, scene units.
    unit: f64,
}

impl Mount {
    /// Of a camera that turns about a point so far ahead of it.
    pub(crate) fn new(camera: &Camera, distance: f32, unit: f32) -> Self {
        let m = camera.camera_to_world.map(f64::from);
        let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
        let axes = DMat3::from_cols(column(0), column(1), column(2));
        Self { axes, eye: column(3), distance: distance.into(), unit: unit.into() }
    }

    /// The axes and the place of the camera with a correction.
    fn corrected(&self, own: &[f64; PER_VIEW]) -> (DMat3, DVec3) {
        let [a, b, c, shift @ ..] = *own;
        let turned = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(a, b, c)));
        let local = (turned.z_axis - DVec3::Z) * self.distance + DVec3::from(shift) * self.unit;
        (self.axes * turned, self.eye + self.axes * local)
    }

    /// The camera with a correction.
    pub(crate) fn camera(&self, given: &Camera, own: &[f32; PER_VIEW]) -> Camera {
        let (axes, eye) = self.corrected(&own.map(f64::from));
        let mut camera = *given;
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis, eye];
        for (column, values) in columns.iter().enumerate() {
            let rows = values.to_array().into_iter().enumerate();
            rows.for_each(|(row, v)| camera.camera_to_world[4 * row + column] = v as f32);
        }
        camera
    }

    /// By how much the camera turns, radians, and moves, scene units.
    pub(crate) fn size(&self, own: &[f32; PER_VIEW]) -> [f64; 2] {
        let own = own.map(f64::from);
        [DVec3::from_slice(&own[..3]).length(), self.corrected(&own).1.distance(self.eye)]
    }

    /// From the force on the camera and the torque about it, in the scene, to the gradient of its
    /// correction.
    pub(crate) fn gradient(&self, own: &[f32; PER_VIEW], pull: &[f32; 6]) -> [f32; PER_VIEW] {
        let (own, pull) = (own.map(f64::from), pull.map(f64::from));
        let (axes, _) = self.corrected(&own);
        let (force, torque) = (DVec3::from_slice(&pull[..3]), DVec3::from_slice(&pull[3..]));
        // About what it turns about.
        let torque = torque + (axes.z_axis * self.distance).cross(force);
        let to_local = self.axes.transpose();
        let turn = left_jacobian(DVec3::from_slice(&own[..3])).transpose() * (to_local * torque);
        let [a, b, c] = turn.to_array().map(|v| v as f32);
        let [x, y, z] = (to_local * force * self.unit).to_array().map(|v| v as f32);
        [a, b, c, x, y, z]
    }

    /// The small correction that turns the camera's axes and moves its place like this.
    pub(crate) fn small(&self, turn: DVec3, moved: impl Fn(DVec3) -> DVec3) -> [f64; PER_VIEW] {
        let to_local = self.axes.transpose();
        let turn = to_local * turn;
        let orbit = turn.cross(DVec3::Z) * self.distance;
        let shift = (to_local * moved(self.eye) - orbit) / self.unit;
        [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z]
    }
}

/// How the rotation of a rotation vector turns where that changes: by this matrix times the
/// change, as a rotation vector from the left.
fn left_jacobian(w: DVec3) -> DMat3 {
    let angle = w.length();
    // (1 - cos) / angle² and (angle - sin) / angle³.
    let [once, twice] = match angle < SMALL {
        true => [0.5, 1.0 / 6.0],
        false => {
            let square = angle * angle;
            [(1.0 - angle.cos()) / square, (angle - angle.sin()) / (square * angle)]
        }
    };
    let cross = DMat3::from_cols(w.cross(DVec3::X), w.cross(DVec3::Y), w.cross(DVec3::Z));
    DMat3::IDENTITY + cross * once + cross * cross * twice
}
