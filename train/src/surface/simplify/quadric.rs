//! How far a point is from planes.

use std::ops::AddAssign;

use glam::{DMat3, DVec3};

/// How much a vertex is drawn to the middle of its edge, and a long edge costs, beside all planes:
/// where these leave it open, as on a wall, this decides.
const MIDDLE: f64 = 1e-5;
/// The least weight of it.
const LEAST: f64 = 1e-30;

/// The sum of squared distances to planes, each with a weight: `p·Ap + 2 b·p + c` at a point `p`.
#[derive(Clone, Copy)]
pub(super) struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
    }
}

impl Quadric {
    /// Of no plane.
    pub(super) const NONE: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    /// Of a plane through a point across a direction; nothing where that has no length.
    pub(super) fn plane(point: DVec3, across: DVec3, weight: f64) -> Self {
        let normal = across.normalize_or_zero();
        let away = normal.dot(point);
        let a = weight * DMat3::from_cols(normal.x * normal, normal.y * normal, normal.z * normal);
        Self { a, b: -weight * away * normal, c: weight * away * away }
    }

    fn at(&self, p: DVec3) -> f64 {
        p.dot(self.a * p) + 2.0 * self.b.dot(p) + self.c
    }

    /// Where the sum is least, near the middle of an edge, and how large it is there; never negative.
    pub(super) fn least(&self, middle: DVec3, length_squared: f64) -> (DVec3, f64) {
        let weight = self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z;
        let pull = MIDDLE * weight + LEAST;
        let held = self.a + DMat3::from_diagonal(DVec3::splat(pull));
        let place = middle - held.inverse() * (self.a * middle + self.b);
        (place, self.at(place).max(0.0) + MIDDLE * MIDDLE * weight * length_squared)
    }
}
