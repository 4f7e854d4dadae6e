//! The part of scene space that a field fills, and how its points become the
//! field's own unit coordinates.
//!
//! Public rays and distances are Euclidean and in scene units; whatever a
//! field needs otherwise is done here. NDC and contracted space will be
//! further variants.

use glam::Vec3;

use crate::{Error, Ray};

/// Where a field lives.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Space {
    /// An axis-aligned box in scene units. Nothing lies outside it.
    Box {
        /// Smallest corner.
        min: [f32; 3],
        /// Largest corner.
        max: [f32; 3],
    },
}

/// The affine map from scene space into the unit cube: `u = (p - min) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitMap {
    /// Scene point that becomes the origin.
    pub min: [f32; 3],
    /// Unit lengths per scene unit, the same along every axis.
    pub scale: f32,
}

impl UnitMap {
    /// Scene point to unit coordinates.
    #[inline(always)]
    #[must_use]
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        [
            (p[0] - self.min[0]) * self.scale,
            (p[1] - self.min[1]) * self.scale,
            (p[2] - self.min[2]) * self.scale,
        ]
    }
}

impl Space {
    /// Checks that the box is finite and not empty.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        let Self::Box { min, max } = self;
        for (lo, hi) in min.iter().zip(max) {
            let side = hi - lo;
            if !(side.is_finite() && lo.is_finite() && side > 1e-6 && side < 1e6) {
                return Err(Error::Range("the box of the scene"));
            }
        }
        Ok(())
    }

    /// The map into the unit cube. The longest side becomes 1, so that cells
    /// stay cubes; the shorter sides use a part of [0, 1].
    #[must_use]
    pub fn unit_map(&self) -> UnitMap {
        let Self::Box { min, max } = self;
        let side = (max[0] - min[0]).max(max[1] - min[1]).max(max[2] - min[2]);
        UnitMap { min: *min, scale: 1.0 / side }
    }

    /// Distances at which `ray` enters and leaves, at least `near` and at most
    /// `far`; the same where it touches an edge or corner, `None` where it
    /// misses. Rays with zero or non-finite components give an answer, never NaN.
    ///
    /// The distances are rounded: which sample lies in the box is for
    /// [`contains`](Self::contains) to say.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, near: f32, far: f32) -> Option<[f32; 2]> {
        let Self::Box { min, max } = self;
        let (mut t0, mut t1) = (near, far);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if !(o.is_finite() && d.is_finite()) {
                return None;
            }
            if d == 0.0 {
                // Parallel to the slab: inside or never.
                if o < min[axis] || o > max[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
            t0 = t0.max(a.min(b));
            t1 = t1.min(a.max(b));
        }
        (t0 <= t1).then_some([t0, t1])
    }

    /// Whether a scene point lies in the box, faces included.
    #[inline(always)]
    #[must_use]
    pub fn contains(&self, p: [f32; 3]) -> bool {
        let Self::Box { min, max } = self;
        (0..3).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis])
    }

    /// The middle of the box, scene units.
    #[must_use]
    pub fn center(&self) -> [f32; 3] {
        let Self::Box { min, max } = self;
        ((Vec3::from(*min) + Vec3::from(*max)) * 0.5).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Space = Space::Box { min: [-1.0, -1.0, -2.0], max: [1.0, 1.0, 2.0] };

    fn hit(origin: [f32; 3], direction: [f32; 3]) -> Option<[f32; 2]> {
        BOX.intersect(&Ray { origin, direction }, 0.0, 100.0)
    }

    #[test]
    fn slabs_by_hand() {
        assert_eq!(hit([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]), Some([3.0, 7.0]));
        assert_eq!(hit([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Some([0.0, 1.0]));
        assert_eq!(hit([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(hit([3.0, 0.0, 5.0], [0.0, 0.0, -1.0]), None);
        // On a face, parallel to it.
        assert_eq!(hit([1.0, 0.0, 5.0], [0.0, 0.0, -1.0]), Some([3.0, 7.0]));
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(hit([bad, 0.0, 0.0], [0.0, 0.0, 1.0]), None);
            assert_eq!(hit([0.0; 3], [bad, 0.0, 1.0]), None);
        }
        assert_eq!(hit([0.0; 3], [f32::from_bits(1), 0.0, 1.0]), Some([0.0, 2.0]));
        // Through the edge x = 1, z = 2, and past it.
        assert_eq!(hit([2.0, 0.0, 1.0], [-0.5, 0.0, 0.5]), Some([2.0, 2.0]));
        assert_eq!(hit([2.0, 0.0, 1.01], [-0.5, 0.0, 0.5]), None);
    }

    #[test]
    fn longest_side_is_one() {
        let map = BOX.unit_map();
        assert_eq!(map.apply([-1.0, -1.0, 2.0]), [0.0, 0.0, 1.0]);
        assert_eq!(map.apply([1.0, 1.0, -2.0]), [0.5, 0.5, 0.0]);
    }
}
