//! Samples near their cameras learn less (Philip and Deschaintre 2023, "Floaters No More").
//!
//! A unit of space is crossed by the more rays of a camera, the nearer it is to it, in proportion
//! to the inverse of the squared distance. So fog before a camera learns faster than the scene,
//! and explains a photograph that no other one contradicts.

use pocketnerf_core::space::UnitMap;
use pocketnerf_core::{Ray, Space};

/// So many times the nearest depth of the scene: nearer samples are slowed down.
const TIMES: f32 = 2.0;

/// How much less samples learn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlowBelow {
    space: Space,
    map: UnitMap,
    /// Inverse of the squared distance, unit lengths, from which on all is learnt.
    inverse: f32,
}

impl SlowBelow {
    /// For a space in which nothing is nearer to a camera than `nearest`, scene units.
    pub(crate) fn new(space: &Space, nearest: Option<f32>) -> Option<Self> {
        let unit = match space {
            Space::Box { .. } => 1.0,
            Space::Contracted(contracted) => contracted.radius,
            _ => return None,
        };
        let (space, map) = (*space, space.unit_map());
        let distance = TIMES * nearest? / unit * map.scale;
        (distance > 0.0).then(|| Self { space, map, inverse: 1.0 / (distance * distance) })
    }

    /// The distance, unit lengths, from which on all is learnt.
    #[cfg(feature = "gpu")]
    pub(crate) fn distance(&self) -> f32 {
        1.0 / self.inverse.sqrt()
    }

    /// The share of its gradient that the sample of a ray at unit point `u` learns from.
    #[inline(always)]
    pub(super) fn share(&self, ray: &Ray, u: [f32; 3]) -> f32 {
        let o = match &self.space {
            Space::Contracted(space) => space.local_point(ray.origin),
            _ => ray.origin,
        };
        let o = self.map.apply(o);
        let square: f32 = (0..3).map(|a| (u[a] - o[a]) * (u[a] - o[a])).sum();
        (square * self.inverse).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::space::Contracted;

    use super::*;

    #[test]
    fn shares_by_hand() {
        // Four scene units along the longest side are one unit length.
        let space = Space::Box { min: [-2.0, -1.0, -1.0], max: [2.0, 1.0, 1.0] };
        let slow = SlowBelow::new(&space, Some(0.5)).unwrap();
        let ray = Ray { origin: [-2.0, -1.0, -1.0], direction: [1.0, 0.0, 0.0] };
        // All from one scene unit on, a quarter of a unit length.
        for (u, share) in [(0.0, 0.0), (0.125, 0.25), (0.25, 1.0), (0.75, 1.0)] {
            assert_eq!(slow.share(&ray, [u, 0.0, 0.0]), share, "{u}");
        }
        // In contracted space a local unit is a radius: half of one from the camera on.
        let around = Contracted { center: [0.0; 3], radius: 2.0 };
        let slow = SlowBelow::new(&Space::Contracted(around), Some(0.5)).unwrap();
        let ray = Ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0] };
        for (local, share) in [(0.0, 0.0), (0.25, 0.25), (0.5, 1.0)] {
            assert_eq!(slow.share(&ray, [0.5 + local / 4.0, 0.5, 0.5]), share, "{local}");
        }
        assert!(SlowBelow::new(&space, None).is_none());
        assert!(SlowBelow::new(&space, Some(0.0)).is_none());
    }
}
