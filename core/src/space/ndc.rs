//! Normalised device coordinates: the space of forward-facing captures
//! (Mildenhall et al. 2020, supplement C).
//!
//! Cameras look along -z, more or less. A scene point (x, y, z) in front of the
//! near plane z = -n becomes
//!
//! ```text
//! x' = -ax x / z      y' = -ay y / z      z' = 1 + 2 n / z
//! ```
//!
//! with ax and ay the focal lengths over half the picture's width and height. What
//! a camera at the origin sees between the near plane and infinity fills
//! [-1, 1]³; straight lines stay straight, and equal steps in z' are equal steps in
//! 1 / z.

use crate::math;
use crate::{Error, Ray};

/// Normalised device coordinates, and the box in them that a field fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ndc {
    /// Distance n of the near plane from the origin, scene units: nothing nearer is
    /// seen.
    pub near: f32,
    /// Focal length over half the picture's width, and over half its height: ax, ay.
    pub slope: [f32; 2],
    /// Smallest corner of the field's box; -1 along z is the near plane.
    pub min: [f32; 3],
    /// Largest corner; 1 along z is infinity.
    pub max: [f32; 3],
}

/// Rays whose direction has a z above this never enter.
const FORWARDS: f64 = -1e-6;
/// Share of the way to infinity that is as far as depths go.
const FARTHEST: f64 = 1.0 - 1.0 / (1 << 22) as f64;

/// A ray on its way through the coordinates, in f64: what is rounded at the end is
/// the same for everyone who computes it.
struct Path {
    /// Where it enters, local coordinates.
    origin: [f64; 3],
    /// From there to infinity.
    way: [f64; 3],
    /// Length of that.
    length: f64,
    /// Distance along the public ray to where it enters, scene units.
    begin: f64,
    /// From there, how far it is to half of the way.
    half: f64,
}

impl Ndc {
    pub(super) fn validate(&self) -> Result<(), Error> {
        let sound = |v: f32| (1e-6..1e6).contains(&v);
        let in_depth = self.min[2] >= -1.0 && self.max[2] <= 1.0;
        if !(sound(self.near) && self.slope.into_iter().all(sound) && in_depth) {
            return Err(Error::Range("normalised device coordinates"));
        }
        Ok(())
    }

    pub(super) const fn bounds(&self) -> [[f32; 3]; 2] {
        [self.min, self.max]
    }

    /// How far a local ray goes until infinity.
    #[inline(always)]
    pub(super) fn length(&self, local: &Ray) -> f32 {
        (1.0 - local.origin[2]) / local.direction[2]
    }

    /// `None` for rays that do not go forwards.
    fn path(&self, ray: &Ray) -> Option<Path> {
        let [ox, oy, oz] = ray.origin.map(f64::from);
        let [dx, dy, dz] = ray.direction.map(f64::from);
        let near = f64::from(self.near);
        let finite = ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite());
        if !(finite && dz < FORWARDS) {
            return None;
        }
        // From the near plane on, or from the eye where that lies beyond it.
        let z = if oz > -near { -near } else { oz };
        let (x, y) = (ox + (z - oz) * (dx / dz), oy + (z - oz) * (dy / dz));
        let [ax, ay] = self.slope.map(f64::from);
        let origin = [-ax * (x / z), -ay * (y / z), 1.0 + 2.0 * near / z];
        let way = [-ax * (dx / dz - x / z), -ay * (dy / dz - y / z), -2.0 * near / z];
        let length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        Some(Path { origin, way, length, begin: (z - oz) / dz, half: z / dz })
    }

    /// Kept apart: the renderer calls it in one place, for each ray.
    #[inline(never)]
    pub(super) fn local(&self, ray: &Ray) -> Option<Ray> {
        let Path { origin, way, length, .. } = self.path(ray)?;
        let local =
            Ray { origin: origin.map(|v| v as f32), direction: way.map(|v| (v / length) as f32) };
        let finite = local.origin.iter().chain(&local.direction).all(|v| v.is_finite());
        // A ray from infinitely far away goes nowhere.
        (finite && local.direction[2] > 0.0).then_some(local)
    }

    #[inline(never)]
    pub(super) fn depth(&self, ray: &Ray, t: f32) -> f32 {
        let (true, Some(path)) = (t.is_finite(), self.path(ray)) else { return t };
        // Half of the way takes `half`, three quarters three times that ...
        let share = (f64::from(t) / path.length).clamp(0.0, FARTHEST);
        let depth = path.begin + path.half * share / (1.0 - share);
        (depth as f32).min(f32::MAX)
    }

    pub(super) fn scene_point(&self, p: [f32; 3]) -> [f32; 3] {
        let beyond = (1.0 - p[2]).max(1e-6);
        let z = -2.0 * self.near / beyond;
        [-p[0] * z / self.slope[0], -p[1] * z / self.slope[1], z]
    }
}

/// Square root to the last bits, of numbers far from the ends of f32's range.
fn sqrt(x: f64) -> f64 {
    let guess = f64::from(math::sqrt(x as f32));
    0.5 * (guess + x / guess)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Space;

    /// 90° wide and 53.13° high: slopes 1 and 2; near plane at 1/2.
    const NDC: Ndc = Ndc { near: 0.5, slope: [1.0, 2.0], min: [-1.0; 3], max: [1.0; 3] };

    fn close(found: [f32; 3], hand: [f32; 3]) {
        for (a, b) in found.iter().zip(hand) {
            assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{found:?}, by hand {hand:?}");
        }
    }

    #[test]
    fn a_ray_by_hand() {
        // From (1, 0, 1/2) along (-2, 1, -2) / 3. It meets z = -1/2 after 3/2, at
        // (0, 1/2, -1/2): there x' = 0, y' = 2 * 1/2 / (1/2) = 2, z' = -1. It goes to
        // x' = -1 * (-2 / -2) = -1, y' = -2 * (1 / -2) = 1, z' = 1: the way is
        // (-1, -1, 2), of length root 6.
        let ray = Ray { origin: [1.0, 0.0, 0.5], direction: [-2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0] };
        let local = NDC.local(&ray).unwrap();
        let root = 6f32.sqrt();
        close(local.origin, [0.0, 2.0, -1.0]);
        close(local.direction, [-1.0 / root, -1.0 / root, 2.0 / root]);
        // Half of the way: 1 / z has halved, z = -1. That is 3/2 + 3/4 along the ray,
        // at (-1/2, 3/4, -1).
        let space = Space::Ndc(NDC);
        let half = 0.5 * root;
        assert!((space.depth(|| ray, half) - 2.25).abs() < 1e-5);
        close([0, 1, 2].map(|a| local.origin[a] + half * local.direction[a]), [-0.5, 1.5, 0.0]);
        close(NDC.scene_point([-0.5, 1.5, 0.0]), [-0.5, 0.75, -1.0]);
        // The box begins at y' = 1, which is at infinity.
        let [t0, t1] = space.intersect(&local, 0.0, 9.0).unwrap();
        assert!((t0 - root).abs() < 1e-5 && (t1 - root).abs() < 1e-5);
        // From beyond the near plane nothing behind the eye is seen: from z = -2,
        // straight on, z' = 1/2.
        let beyond = Ray { origin: [0.0, 0.0, -2.0], direction: [0.0, 0.0, -1.0] };
        let local = NDC.local(&beyond).unwrap();
        assert_eq!((local.origin, local.direction), ([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]));
        // z' = 3/4 is z = -4.
        assert_eq!(space.depth(|| beyond, 0.25), 2.0);
        assert_eq!(space.center(), [0.0, 0.0, -1.0]);
    }

    #[test]
    fn depths_are_those_of_the_points() {
        let space = Space::Ndc(NDC);
        for origin in [[0.0; 3], [0.3, -0.2, 0.4], [-0.1, 0.4, -0.7]] {
            for (x, y) in [(0.0, 0.0), (0.7, -0.4), (-0.9, 0.9), (5.0, 1.0)] {
                let length = math::sqrt(x * x + y * y + 1.0);
                let ray = Ray { origin, direction: [x / length, y / length, -1.0 / length] };
                let local = space.local(&ray).unwrap();
                let end = (1.0 - local.origin[2]) / local.direction[2];
                let mut last = -1.0;
                for k in 0..=100 {
                    let t = end * k as f32 / 100.0;
                    let depth = space.depth(|| ray, t);
                    assert!(depth > last && depth.is_finite(), "{depth} after {last}");
                    last = depth;
                    if k < 90 {
                        let p = [0, 1, 2].map(|a| local.origin[a] + t * local.direction[a]);
                        let q = [0, 1, 2].map(|a| ray.origin[a] + depth * ray.direction[a]);
                        let p = space.scene_point(p);
                        let off = (0..3).map(|a| (p[a] - q[a]).abs()).fold(0.0, f32::max);
                        assert!(off <= 1e-4 * depth.max(0.1), "{p:?} {q:?}");
                    }
                }
                assert!(last > 1e6);
            }
        }
        let ahead = Ray { origin: [0.0; 3], direction: [0.0, 0.0, -1.0] };
        assert_eq!(space.depth(|| ahead, f32::INFINITY), f32::INFINITY);
        assert!(space.depth(|| ahead, f32::MAX).is_finite());
    }

    #[test]
    fn rays_that_see_nothing() {
        let see = |origin, direction| NDC.local(&Ray { origin, direction }).is_some();
        assert!(see([0.0; 3], [0.0, 0.0, -1.0]));
        assert!(!see([0.0; 3], [0.0, 0.0, 1.0]));
        assert!(!see([0.0; 3], [1.0, 0.0, 0.0]));
        assert!(!see([0.0; 3], [1.0, 0.0, -1e-7]));
        assert!(see([0.0; 3], [1.0, 0.0, -1e-5]));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let (mut origin, mut direction) = ([0.0; 3], [0.0, 0.0, -1.0]);
                origin[axis] = bad;
                assert!(!see(origin, direction), "{origin:?}");
                direction[axis] = bad;
                assert!(!see([0.0; 3], direction), "{direction:?}");
            }
        }
        // So far away that there is no way left.
        assert!(!see([0.0, 0.0, -f32::MAX], [0.0, 0.0, -1.0]));
        assert!(!see([f32::MAX, 0.0, 0.0], [0.0, 0.0, -1.0]));
    }

    #[test]
    fn refuses_what_is_no_such_space() {
        assert_eq!(Space::Ndc(NDC).validate(), Ok(()));
        let wide = Ndc { min: [-2.0, -3.0, -1.0], max: [2.0, 1.5, 0.5], ..NDC };
        assert_eq!(Space::Ndc(wide).validate(), Ok(()));
        for wrong in [
            Ndc { near: 0.0, ..NDC },
            Ndc { near: f32::NAN, ..NDC },
            Ndc { near: -1.0, ..NDC },
            Ndc { slope: [1.0, 0.0], ..NDC },
            Ndc { slope: [f32::INFINITY, 1.0], ..NDC },
            Ndc { max: [1.0, 1.0, 1.5], ..NDC },
            Ndc { min: [-1.0, -1.0, -1.5], ..NDC },
            Ndc { min: [1.0, -1.0, -1.0], ..NDC },
        ] {
            assert!(matches!(Space::Ndc(wrong).validate(), Err(Error::Range(_))), "{wrong:?}");
        }
    }
}
