//! A path on a plane.

use glam::Vec3;

use super::{Photograph, mean, meeting, pose};

/// Cameras that look in one direction, on a plane across it.
pub(super) struct Ellipse {
    middle: Vec3,
    /// Its half axes.
    right: Vec3,
    above: Vec3,
    back: Vec3,
    up: Vec3,
    /// What it looks at, where the photographs look at something.
    target: Option<Vec3>,
}

impl Ellipse {
    pub(super) fn new(photographs: &[Photograph], back: Vec3, up: Vec3) -> Self {
        let middle = mean(photographs, |photograph| photograph.position);
        let right = up.cross(back).normalize_or(back.any_orthonormal_vector());
        let above = back.cross(right);
        // Of points spread evenly over an ellipse, the mean square is a quarter of the square of
        // its half axis: seven tenths of that.
        let along = |axis: Vec3| {
            let square = |photograph: &Photograph| {
                let along = axis.dot(photograph.position - middle);
                Vec3::splat(along * along)
            };
            axis * (2.0 * mean(photographs, square).x).sqrt()
        };
        // In front of all of them.
        let target = meeting(photographs)
            .filter(|target| photographs.iter().all(|p| p.back.dot(p.position - *target) > 0.0));
        Self { middle, right: along(right), above: along(above), back, up, target }
    }

    pub(super) fn pose(&self, turn: f32) -> [f32; 16] {
        let (sin, cos) = turn.sin_cos();
        let position = self.middle + cos * self.right + sin * self.above;
        let back = self.target.map_or(self.back, |target| (position - target).normalize());
        pose(position, back, self.up)
    }
}
