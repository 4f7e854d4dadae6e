//! The capture's world: scaled, turned, perhaps made a sphere.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DMat4, DVec3};
use pocketnerf_core::query::Similarity;

use crate::cameras::nearest_to_axes;
use crate::dataset::Own;

/// The nearest depth of all lies here: behind the near plane of normalised device
/// coordinates, which is at 1.
const NEAREST: f64 = 1.0 / 0.75;
/// Cameras that are turned by more than this away from their mean direction, radians, look from
/// several sides: 30 degrees.
const SIDES: f64 = std::f64::consts::FRAC_PI_6;

/// Poses, depths and points.
#[derive(Debug)]
pub(in crate::dataset) struct World {
    poses: Vec<DMat4>,
    /// Angle between a camera's axis and its pictures' corners.
    half_angles: Vec<f64>,
    /// What is known to be somewhere.
    points: Vec<DVec3>,
    near: f64,
    far: f64,
    /// From the capture's own coordinates to these.
    moved: DMat4,
    /// What is up in these.
    up: DVec3,
}

impl Default for World {
    fn default() -> Self {
        let (poses, half_angles, points) = (Vec::new(), Vec::new(), Vec::new());
        let (near, far, moved, up) = (f64::INFINITY, 0.0, DMat4::IDENTITY, DVec3::Z);
        Self { poses, half_angles, points, near, far, moved, up }
    }
}

impl World {
    /// Adds a camera: 16 numbers, row after row, and the angle between its axis and its
    /// picture's corners.
    pub(in crate::dataset) fn push(&mut self, pose: &[f64], half_angle: f64) {
        let rows: [f64; 16] = std::array::from_fn(|i| pose[i]);
        self.poses.push(DMat4::from_cols_array(&rows).transpose());
        self.half_angles.push(half_angle);
    }

    /// Adds the depths between which a camera sees something.
    pub(in crate::dataset) fn see(&mut self, [near, far]: [f64; 2]) {
        self.near = self.near.min(near);
        self.far = self.far.max(far);
    }

    /// Adds points of the scene.
    pub(in crate::dataset) fn add_points(&mut self, points: impl IntoIterator<Item = DVec3>) {
        self.points.extend(points);
    }

    /// Scales the world so that the nearest depth is [`NEAREST`], and moves the average
    /// camera to the origin, looking along −z.
    pub(in crate::dataset) fn recentre(&mut self) {
        self.scale(NEAREST / self.near);
        let sum = |axis: usize| self.poses.iter().map(|p| p.col(axis).truncate()).sum::<DVec3>();
        let back = sum(2).normalize_or(DVec3::Z);
        let right = sum(1).cross(back).normalize_or(back.any_orthonormal_vector());
        let up = back.cross(right);
        let center = sum(3) / self.poses.len() as f64;
        self.see_from(right, up, back, center);
        self.up = DVec3::Y;
    }

    /// Moves the point that all cameras look at to the origin, the side that they are on
    /// to +z, and scales the world so that their root mean square distance is 1. False,
    /// and nothing done, where they do not look at a point.
    pub(in crate::dataset) fn spherify(&mut self) -> bool {
        let poses: Vec<[f32; 16]> =
            self.poses().map(|pose| std::array::from_fn(|i| pose[i] as f32)).collect();
        let Some(center) = nearest_to_axes(&poses) else { return false };
        let away = |pose: &DMat4| pose.col(3).truncate() - center;
        let side = self.poses.iter().map(away).sum::<DVec3>();
        let distances: f64 = self.poses.iter().map(|pose| away(pose).length()).sum();
        // Cameras on all sides: what they call up.
        let on_all_sides = side.length() < 1e-3 * distances;
        let up =
            if on_all_sides { self.poses.iter().map(|p| p.col(1).truncate()).sum() } else { side };
        let up = up.normalize_or(DVec3::Z);
        // Any vector that is not along it.
        let right = DVec3::new(0.1, 0.2, 0.3).cross(up);
        let right = right.normalize_or(up.any_orthonormal_vector());
        self.see_from(right, up.cross(right), up, center);
        self.scale(1.0 / self.radius());
        self.up = DVec3::Z;
        true
    }

    /// Moves the point that the cameras look at to the origin, and turns what they call up to +z
    /// and the side that most are on to +x. Where they look at no point, the middle of them.
    pub(in crate::dataset) fn stand_up(&mut self) {
        self.stand_along(self.mean(1));
    }

    /// The same with a direction that is up.
    pub(in crate::dataset) fn stand_along(&mut self, up: DVec3) {
        // Far from the origin, as on the globe, single precision is too coarse.
        self.see_from(DVec3::X, DVec3::Y, DVec3::Z, self.mean(3));
        let poses: Vec<[f32; 16]> =
            self.poses().map(|pose| std::array::from_fn(|i| pose[i] as f32)).collect();
        let center = nearest_to_axes(&poses).unwrap_or_default();
        let up = up.normalize_or(DVec3::Z);
        let side = (self.mean(3) - center).reject_from_normalized(up);
        let side = side.normalize_or(up.any_orthonormal_vector());
        self.see_from(side, up.cross(side), up, center);
        self.up = DVec3::Z;
    }

    /// Whether any picture shows what is more than 90° away from the mean direction:
    /// normalised device coordinates have no place for that.
    pub(in crate::dataset) fn looks_around(&self) -> bool {
        self.turns().zip(&self.half_angles).any(|(angle, half)| angle + half >= FRAC_PI_2)
    }

    /// Whether cameras look at something from several sides, as an arc of them does: cells of
    /// normalised device coordinates are as narrow as one side sees them.
    pub(in crate::dataset) fn looks_from_sides(&self) -> bool {
        self.turns().any(|angle| angle > SIDES)
    }

    /// By how much each camera is turned away from the mean direction, radians.
    fn turns(&self) -> impl Iterator<Item = f64> {
        let back = |pose: &DMat4| pose.col(2).truncate().normalize_or_zero();
        let mean = self.poses.iter().map(back).sum::<DVec3>().normalize_or_zero();
        self.poses.iter().map(move |pose| back(pose).dot(mean).clamp(-1.0, 1.0).acos())
    }

    /// Nearest and farthest depth.
    pub(in crate::dataset) fn bounds(&self) -> [f32; 2] {
        [self.near as f32, self.far as f32]
    }

    /// The mean of a column of all poses: 3 is where they are.
    pub(in crate::dataset) fn mean(&self, column: usize) -> DVec3 {
        let columns = self.poses.iter().map(|pose| pose.col(column).truncate());
        columns.sum::<DVec3>() / self.poses.len() as f64
    }

    /// Root mean square distance of the cameras from the origin; 1 where they all are there.
    pub(in crate::dataset) fn radius(&self) -> f64 {
        let squares = self.poses.iter().map(|pose| pose.col(3).truncate().length_squared());
        let radius = (squares.sum::<f64>() / self.poses.len() as f64).sqrt();
        if radius > 0.0 { radius } else { 1.0 }
    }

    /// Row after row.
    pub(in crate::dataset) fn poses(&self) -> impl Iterator<Item = [f64; 16]> {
        self.poses.iter().map(|pose| pose.transpose().to_cols_array())
    }

    pub(in crate::dataset) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The capture's own coordinates; `None` where single precision has no numbers for the way
    /// there.
    pub(in crate::dataset) fn own(&self) -> Option<Own> {
        let (scale, rotation, translation) = self.moved.inverse().to_scale_rotation_translation();
        let rows = DMat3::from_quat(rotation).transpose().to_cols_array_2d();
        let similarity = Similarity {
            scale: scale.x as f32,
            rotation: rows.map(|row| row.map(|v| v as f32)),
            translation: translation.to_array().map(|v| v as f32),
        };
        let up = (rotation * self.up).to_array().map(|v| v as f32);
        similarity.validate().is_ok().then_some(Own { similarity, up })
    }

    pub(in crate::dataset) fn scale(&mut self, by: f64) {
        self.moved = DMat4::from_scale(DVec3::splat(by)) * self.moved;
        self.points.iter_mut().for_each(|point| *point *= by);
        for pose in &mut self.poses {
            pose.w_axis = (pose.w_axis.truncate() * by).extend(1.0);
        }
        self.near *= by;
        self.far *= by;
    }

    /// The world along these axes, seen from this point.
    fn see_from(&mut self, right: DVec3, up: DVec3, back: DVec3, center: DVec3) {
        let view = DMat4::from_cols(
            right.extend(0.0),
            up.extend(0.0),
            back.extend(0.0),
            center.extend(1.0),
        );
        let to_view = view.inverse();
        self.moved = to_view * self.moved;
        self.poses.iter_mut().for_each(|pose| *pose = to_view * *pose);
        self.points.iter_mut().for_each(|point| *point = to_view.transform_point3(*point));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cameras that look at the origin, turned by so many degrees to the left and right.
    fn apart(degrees: f64) -> World {
        let mut world = World::default();
        for angle in [-degrees, degrees] {
            let pose = DMat4::from_rotation_y(angle.to_radians())
                * DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0));
            world.push(&pose.transpose().to_cols_array(), 0.5);
        }
        world
    }

    #[test]
    fn an_arc_of_cameras_looks_from_several_sides() {
        let of = |degrees| [apart(degrees).looks_from_sides(), apart(degrees).looks_around()];
        assert_eq!([29.0, 31.0, 62.0].map(of), [[false, false], [true, false], [true, true]]);
    }
}
