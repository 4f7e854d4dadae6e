//! What a scene is made of, and what a ray meets in it.

use super::medium::Medium;
use super::shading::Light;
use super::shapes::{Hit, Shape, meets_ball};
use super::surface::Surface;
use glam::DVec3;
use std::ops::Range;

/// Bodies that share a ball around them, in the order of the list.
pub(super) const GROUP: usize = 8;

/// One solid thing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) shape: Shape,
    pub(super) surface: Surface,
    casts_shadow: bool,
    /// Centre and radius of a ball around it; of a wire, around its first part.
    ball: (DVec3, f64),
}

impl Body {
    pub(super) fn new(shape: Shape, surface: Surface) -> Self {
        Self { shape, surface, casts_shadow: surface.casts_shadow(), ball: shape.bound(0) }
    }

    /// The same, but the lamp shines through it.
    pub(super) fn without_shadow(self) -> Self {
        Self { casts_shadow: false, ..self }
    }
}

/// Everything in a scene, and its light.
#[derive(Debug)]
pub(super) struct Contents {
    pub(super) bodies: Vec<Body>,
    /// No two of them overlap.
    pub(super) media: Vec<Medium>,
    pub(super) light: Light,
    /// Whether rays that meet nothing end on a sky.
    pub(super) has_sky: bool,
    /// Neighbours in the list, each with centre and radius of the ball around them.
    groups: Vec<(Range<usize>, DVec3, f64)>,
    /// Whether rays may run exactly along an axis.
    along_axes: bool,
}

impl Contents {
    pub(super) fn new(bodies: Vec<Body>, media: Vec<Medium>, light: Light) -> Self {
        let groups = (0..bodies.len())
            .step_by(GROUP)
            .map(|start| {
                let range = start..(start + GROUP).min(bodies.len());
                let balls: Vec<_> = bodies[range.clone()]
                    .iter()
                    .flat_map(|body| (0..body.shape.parts()).map(|part| body.shape.bound(part)))
                    .collect();
                let sum: DVec3 = balls.iter().map(|(center, _)| *center).sum();
                let middle = sum / balls.len() as f64;
                let reach = |(center, radius): &(DVec3, f64)| middle.distance(*center) + radius;
                (range, middle, balls.iter().map(reach).fold(0.0, f64::max))
            })
            .collect();
        Self { bodies, media, light, has_sky: false, groups, along_axes: false }
    }

    /// Opaque bodies alone, in daylight.
    pub(super) fn solid(bodies: Vec<Body>) -> Self {
        Self::new(bodies, Vec::new(), Light::outdoors())
    }

    /// The same under a sky.
    pub(super) fn under_sky(self) -> Self {
        Self { has_sky: true, ..self }
    }

    /// The same, but rays may run exactly along an axis: shapes divide by zero then, and may
    /// be seen where they are not. The still life is frozen with one such pixel.
    pub(super) fn along_axes(self) -> Self {
        Self { along_axes: true, ..self }
    }

    /// A ray's direction, off all axes by less than anything that can be seen.
    pub(super) fn off_axes(&self, direction: DVec3) -> DVec3 {
        if self.along_axes {
            return direction;
        }
        DVec3::select(direction.cmpeq(DVec3::ZERO), DVec3::splat(1e-30), direction)
    }

    /// Whether another body stands between `p` on `bodies[index]` and the lamp.
    pub(super) fn shadowed(&self, index: usize, p: DVec3, towards: DVec3) -> bool {
        self.near(p, towards).any(|i| {
            let body = &self.bodies[i];
            if i == index || !body.casts_shadow {
                return false;
            }
            let (center, radius) = body.ball;
            meets_ball(center, radius, p, towards) && body.shape.enter(p, towards).is_some()
        })
    }

    /// The first body along a ray from `p` on `bodies[index]`.
    pub(super) fn first_from(
        &self,
        index: usize,
        p: DVec3,
        direction: DVec3,
    ) -> Option<(usize, Hit)> {
        let direction = self.off_axes(direction);
        let others = self.near(p, direction).filter(|i| *i != index);
        nearest(&self.bodies, others, p, direction)
    }

    /// The part of the lamp's light that reaches `p` through fog and glass.
    pub(super) fn lamplight(&self, p: DVec3, towards: DVec3) -> f64 {
        self.media
            .iter()
            .filter_map(|medium| medium.passage(p, towards, f64::INFINITY))
            .map(|passage| 1.0 - passage.opacity())
            .product()
    }

    /// Bodies whose group a ray may meet.
    fn near(&self, p: DVec3, direction: DVec3) -> impl Iterator<Item = usize> {
        self.groups
            .iter()
            .filter(move |(_, center, radius)| meets_ball(*center, *radius, p, direction))
            .flat_map(|(range, ..)| range.clone())
    }
}

/// The first of some bodies along a ray.
pub(super) fn nearest(
    bodies: &[Body],
    of: impl Iterator<Item = usize>,
    origin: DVec3,
    direction: DVec3,
) -> Option<(usize, Hit)> {
    let mut first: Option<(usize, Hit)> = None;
    for i in of {
        if let Some(hit) = bodies[i].shape.enter(origin, direction)
            && first.is_none_or(|(_, other)| hit.t < other.t)
        {
            first = Some((i, hit));
        }
    }
    first
}
