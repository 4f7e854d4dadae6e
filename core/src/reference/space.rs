//! The coordinates in which a ray is marched along, in f64.

use super::contracted::{self, Pieces};
use super::ray;
use crate::{Ray, Space};

/// A ray in the coordinates of its space.
#[allow(clippy::large_enum_variant, reason = "there is no heap to put the pieces on")]
pub(super) enum Path {
    /// It is straight there.
    Straight(Ray),
    /// It is a few straight pieces.
    Bent(Pieces),
}

impl Path {
    /// `None` for directions that do not go there.
    ///
    /// In normalised device coordinates it is the line from where the ray passes the near
    /// plane, or begins beyond it, to where it vanishes: to its direction's own image.
    pub(super) fn new(space: &Space, ray: &Ray) -> Option<Self> {
        match space {
            Space::Box { .. } => Some(Self::Straight(*ray)),
            Space::Ndc(ndc) => ndc::local(ndc, ray).map(Self::Straight),
            Space::Contracted(space) => Pieces::new(space, ray).map(Self::Bent),
        }
    }

    /// The local point at distance `t`.
    pub(super) fn point(&self, t: f32) -> Option<[f32; 3]> {
        match self {
            Self::Straight(local) => Some(ray::point(local, t)),
            Self::Bent(pieces) => pieces.point(t),
        }
    }

    /// Distances between which samples lie that are spread over all that the model holds of
    /// the ray, out of `near` to `far`.
    pub(super) fn clipped(&self, space: &Space, [near, far]: [f32; 2]) -> Option<[f32; 2]> {
        match self {
            Self::Straight(local) => space.intersect(local, near, far),
            Self::Bent(pieces) => Some([near, far.min(pieces.length())]),
        }
    }

    /// How far it goes until infinity, where the space holds that.
    pub(super) fn whole_way(&self, space: &Space) -> Option<f32> {
        match self {
            Self::Straight(_) if space.scene_box().is_some() => None,
            Self::Straight(local) => Some((1.0 - local.origin[2]) / local.direction[2]),
            Self::Bent(pieces) => Some(pieces.length()),
        }
    }

    /// The distance along the public ray, scene units, of what lies at `t` along this one:
    /// from the point there back to scene units.
    pub(super) fn depth(&self, space: &Space, ray: &Ray, t: f64) -> f64 {
        match (self, space) {
            (Self::Bent(pieces), _) => pieces.depth(t),
            (Self::Straight(local), Space::Ndc(ndc)) => ndc::depth(ndc, ray, local, t),
            _ => t,
        }
    }
}

/// The local coordinates of a scene point, `None` where it has none.
pub(super) fn point(space: &Space, p: [f32; 3]) -> Option<[f32; 3]> {
    match space {
        Space::Box { .. } => Some(p),
        Space::Ndc(ndc) => ndc::point(ndc, p),
        Space::Contracted(space) => Some(contracted::point(space, p)),
    }
}

#[cfg(feature = "ndc")]
mod ndc {
    use crate::Ray;
    use crate::space::Ndc;

    pub(super) fn local(ndc: &Ndc, ray: &Ray) -> Option<Ray> {
        let [o, d] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
        if !(o.iter().chain(&d).all(|v| v.is_finite()) && d[2] < -1e-6) {
            return None;
        }
        let z = o[2].min(-f64::from(ndc.near));
        let begin = image(ndc, [0, 1, 2].map(|a| o[a] + (z - o[2]) * (d[a] / d[2])));
        let [ax, ay] = ndc.slope.map(f64::from);
        let end = [-ax * (d[0] / d[2]), -ay * (d[1] / d[2]), 1.0];
        let way = [0, 1, 2].map(|a| end[a] - begin[a]);
        let length = super::super::math::sqrt(way.iter().map(|w| w * w).sum());
        let origin = begin.map(|v| v as f32);
        let direction = way.map(|w| (w / length) as f32);
        let sound = origin.iter().chain(&direction).all(|v| v.is_finite());
        (sound && direction[2] > 0.0).then_some(Ray { origin, direction })
    }

    pub(super) fn depth(ndc: &Ndc, ray: &Ray, local: &Ray, t: f64) -> f64 {
        let z = f64::from(local.origin[2]) + t * f64::from(local.direction[2]);
        // Not behind infinity.
        let scene_z = -2.0 * f64::from(ndc.near) / (1.0 - z).max(1e-7);
        (scene_z - f64::from(ray.origin[2])) / f64::from(ray.direction[2])
    }

    pub(super) fn point(ndc: &Ndc, p: [f32; 3]) -> Option<[f32; 3]> {
        let in_front = p[2] <= -ndc.near && p.iter().all(|v| v.is_finite());
        in_front.then(|| image(ndc, p.map(f64::from)).map(|v| v as f32))
    }

    /// The projective map of a camera at the origin with a near plane and no far one.
    fn image(ndc: &Ndc, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [ax, ay] = ndc.slope.map(f64::from);
        [-ax * x / z, -ay * y / z, 1.0 + 2.0 * f64::from(ndc.near) / z]
    }
}

#[cfg(not(feature = "ndc"))]
mod ndc {
    use crate::Ray;
    use crate::space::Ndc;

    pub(super) fn local(ndc: &Ndc, _: &Ray) -> Option<Ray> {
        match *ndc {}
    }

    pub(super) fn depth(ndc: &Ndc, _: &Ray, _: &Ray, _: f64) -> f64 {
        match *ndc {}
    }

    pub(super) fn point(ndc: &Ndc, _: [f32; 3]) -> Option<[f32; 3]> {
        match *ndc {}
    }
}
