//! The part of scene space that a field fills, and how its points become the
//! field's own unit coordinates.
//!
//! Public rays and distances are Euclidean and in scene units. A space has
//! *local* coordinates of its own, in which it is a box and rays are straight:
//! rays march there, in equal steps, and density is per local unit. Those of a
//! [`Space::Box`] are scene units, so that nothing has to be done. In contracted space a
//! ray is a few straight [pieces](Space::piece), one after another.

#[cfg_attr(not(feature = "contracted"), path = "space/no_contracted.rs")]
mod contracted;
#[cfg_attr(not(feature = "ndc"), path = "space/no_ndc.rs")]
mod ndc;

pub use contracted::Contracted;
use glam::Vec3;
pub use ndc::Ndc;

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
    /// What cameras that look the same way see, however far it is.
    Ndc(Ndc),
    /// All that lies around the cameras, however far it is.
    Contracted(Contracted),
}

/// A straight piece of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// A local ray, its direction a unit vector, on which the piece lies. Distances along it
    /// go on from those along the piece before.
    pub local: Ray,
    /// Distance at which the next piece begins, if there is one.
    pub end: f32,
}

/// The affine map from local coordinates into the unit cube: `u = (p - min) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitMap {
    /// Local point that becomes the origin.
    pub min: [f32; 3],
    /// Unit lengths per local unit, the same along every axis.
    pub scale: f32,
}

impl UnitMap {
    /// Local point to unit coordinates.
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
        let [min, max] = self.bounds();
        for (lo, hi) in min.iter().zip(max) {
            let side = hi - lo;
            if !(side.is_finite() && lo.is_finite() && side > 1e-6 && side < 1e6) {
                return Err(Error::Range("the box of the scene"));
            }
        }
        match self {
            Self::Box { .. } => Ok(()),
            Self::Ndc(ndc) => ndc.validate(),
            Self::Contracted(space) => space.validate(),
        }
    }

    /// Smallest and largest corner of the box that the field fills, local coordinates.
    #[inline(always)]
    #[must_use]
    pub const fn bounds(&self) -> [[f32; 3]; 2] {
        match self {
            Self::Box { min, max } => [*min, *max],
            Self::Ndc(ndc) => ndc.bounds(),
            Self::Contracted(space) => space.bounds(),
        }
    }

    /// The box in scene units, where the space is one.
    #[inline(always)]
    #[must_use]
    pub const fn scene_box(&self) -> Option<[[f32; 3]; 2]> {
        match self {
            Self::Box { min, max } => Some([*min, *max]),
            Self::Ndc(_) | Self::Contracted(_) => None,
        }
    }

    /// The map into the unit cube. The longest side becomes 1, so that cells
    /// stay cubes; the shorter sides use a part of [0, 1].
    #[must_use]
    pub fn unit_map(&self) -> UnitMap {
        let [min, max] = self.bounds();
        let side = (max[0] - min[0]).max(max[1] - min[1]).max(max[2] - min[2]);
        UnitMap { min, scale: 1.0 / side }
    }

    /// Whether rays may have several [pieces](Self::piece).
    #[inline(always)]
    #[must_use]
    pub const fn is_bent(&self) -> bool {
        matches!(self, Self::Contracted(_))
    }

    /// The straight piece of the public `ray` on which the local distance `t` lies; `None`
    /// where it never enters the space, or ends before.
    #[inline(always)]
    #[must_use]
    pub fn piece(&self, ray: &Ray, t: f32) -> Option<Piece> {
        let local = match self {
            Self::Box { .. } => *ray,
            Self::Ndc(ndc) => ndc.local(ray)?,
            Self::Contracted(space) => return space.piece(ray, t),
        };
        Some(Piece { local, end: f32::INFINITY })
    }

    /// The public `ray` in local coordinates, its direction a unit vector again: its first
    /// [piece](Self::piece). `None` where it never enters them.
    #[inline(always)]
    #[must_use]
    pub fn local(&self, ray: &Ray) -> Option<Ray> {
        self.piece(ray, 0.0).map(|piece| piece.local)
    }

    /// The distance along the public ray, scene units, of what lies at distance `t`
    /// along its [local](Self::local) one; `ray` gives it where it is needed. It grows
    /// with `t`; what is infinite stays so, and nothing else becomes infinite.
    #[inline(always)]
    #[must_use]
    pub fn depth(&self, ray: impl FnOnce() -> Ray, t: f32) -> f32 {
        match self {
            Self::Box { .. } => {
                let _ = ray;
                t
            }
            Self::Ndc(ndc) => ndc.depth(&ray(), t),
            Self::Contracted(space) => space.depth(&ray(), t),
        }
    }

    /// Local point to scene point. What is infinitely far away comes to lie
    /// very far away.
    #[must_use]
    pub fn scene_point(&self, p: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Box { .. } => p,
            Self::Ndc(ndc) => ndc.scene_point(p),
            Self::Contracted(space) => space.scene_point(p),
        }
    }

    /// Distances at which a [local](Self::local) `ray` enters and leaves, at least
    /// `near` and at most `far`; the same where it touches an edge or corner, `None`
    /// where it misses. Rays with zero or non-finite components give an answer, never
    /// NaN.
    ///
    /// The distances are rounded: which sample lies in the box is for
    /// [`contains`](Self::contains) to say.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, near: f32, far: f32) -> Option<[f32; 2]> {
        let [min, max] = self.bounds();
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

    /// Whether a local point lies in the box, faces included.
    #[inline(always)]
    #[must_use]
    pub fn contains(&self, p: [f32; 3]) -> bool {
        let [min, max] = self.bounds();
        (0..3).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis])
    }

    /// How far the public `ray` goes until infinity, local units, where the space holds that.
    #[inline(always)]
    #[must_use]
    pub fn whole_way(&self, ray: &Ray) -> Option<f32> {
        match self {
            Self::Box { .. } => None,
            Self::Ndc(ndc) => ndc.local(ray).map(|local| ndc.length(&local)),
            Self::Contracted(space) => Some(space.length(ray)),
        }
    }

    /// A distance from the [centre](Self::center) from which a camera sees all that matters,
    /// scene units.
    #[must_use]
    pub fn viewing_distance(&self) -> f32 {
        match self {
            Self::Box { .. } | Self::Ndc(_) => 2.0 / self.unit_map().scale,
            Self::Contracted(space) => space.viewing_distance(),
        }
    }

    /// The scene point in the middle of the box.
    #[must_use]
    pub fn center(&self) -> [f32; 3] {
        let [min, max] = self.bounds();
        self.scene_point(((Vec3::from(min) + Vec3::from(max)) * 0.5).to_array())
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
