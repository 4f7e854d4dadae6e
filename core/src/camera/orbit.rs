//! Cameras around a point.

use glam::Vec3;

use super::Camera;
use crate::math;

/// A camera at a distance from a target that it looks at, placed by two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point in the middle of the picture, scene units.
    pub target: [f32; 3],
    /// Distance from the target, scene units.
    pub radius: f32,
    /// Angle about the axis, radians, counter-clockwise seen from where the axis points; 0
    /// is where the x axis points, or the y axis if x is what the camera goes around.
    pub azimuth: f32,
    /// Angle above the plane through the target and across the axis, radians.
    pub elevation: f32,
    /// The axis that the camera goes around, of any length but 0.
    pub axis: [f32; 3],
    /// The direction that is up in the picture, of any length but 0.
    pub up: [f32; 3],
}

impl Orbit {
    /// The camera-to-world pose, as [`Camera::camera_to_world`] has it.
    #[must_use]
    pub fn pose(&self) -> [f32; 16] {
        let axis = Vec3::from(self.axis).normalize_or(Vec3::Z);
        let start = if axis.x.abs() < 0.999 { Vec3::X } else { Vec3::Y };
        let first = start.reject_from_normalized(axis).normalize();
        let second = axis.cross(first);
        let (rise, reach) = math::sin_cos(self.elevation);
        let (sin, cos) = math::sin_cos(self.azimuth);
        let direction = (first * cos + second * sin) * reach + axis * rise;
        let eye = Vec3::from(self.target) + direction * self.radius;
        Camera::look_at(eye.to_array(), self.target, self.up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_6, PI};

    const AROUND_Z: Orbit = Orbit {
        target: [1.0, 2.0, 3.0],
        radius: 2.0,
        azimuth: 0.0,
        elevation: FRAC_PI_6,
        axis: [0.0, 0.0, 2.0],
        up: [0.0, 0.0, 5.0],
    };

    fn assert_near(found: &[f32], expected: &[f32]) {
        assert_eq!(found.len(), expected.len());
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near, "{found:?} {expected:?}");
    }

    #[test]
    fn a_quarter_turn_at_a_time() {
        // 30° up at distance 2: 1 above the target, √3 aside.
        let side = math::sqrt(3.0);
        let places = [[side, 0.0], [0.0, side], [-side, 0.0], [0.0, -side]];
        for (quarter, [x, y]) in (0..).zip(places) {
            let orbit = Orbit { azimuth: quarter as f32 * FRAC_PI_2, ..AROUND_Z };
            let camera = Camera::from_fov_x(8, 6, FRAC_PI_2, orbit.pose());
            assert_near(&camera.position(), &[1.0 + x, 2.0 + y, 4.0]);
            assert_near(&camera.project(orbit.target).unwrap(), &[4.0, 3.0]);
        }
        // The first camera's right is +y, its up leans back from +z.
        let m = AROUND_Z.pose();
        assert_near(&[m[0], m[4], m[8]], &[0.0, 1.0, 0.0]);
        assert_near(&[m[1], m[5], m[9]], &[-0.5, 0.0, side / 2.0]);
    }

    #[test]
    fn other_axes() {
        let x = Orbit { axis: [1.0, 0.0, 0.0], elevation: 0.0, ..AROUND_Z };
        let position = |orbit: Orbit| [3, 7, 11].map(|i| orbit.pose()[i]);
        assert_near(&position(x), &[1.0, 4.0, 3.0]);
        assert_near(&position(Orbit { azimuth: FRAC_PI_2, ..x }), &[1.0, 2.0, 5.0]);
        let below = Orbit { axis: [0.0, 0.0, -1.0], azimuth: PI, ..AROUND_Z };
        assert_near(&position(below), &[1.0 - math::sqrt(3.0), 2.0, 2.0]);
    }
}
