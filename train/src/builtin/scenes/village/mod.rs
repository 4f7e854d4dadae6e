//! Outdoors: a well, houses and trees around it, and far away more houses and hills. Every
//! ray ends at a body, on the ground, which has no end, or on the sky.

mod far;
mod house;
mod near;
mod well;

use crate::builtin::contents::{Body, Contents, GROUP};
use crate::builtin::shading::Light;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::DVec3;

/// Height of the ground.
pub(in crate::builtin) const GROUND: f64 = -0.5;

const WOOD: Surface = Surface::Stripes {
    period: 0.05,
    colours: [DVec3::new(0.52, 0.36, 0.22), DVec3::new(0.38, 0.25, 0.15)],
};

pub(in crate::builtin) fn contents() -> Contents {
    let mut bodies = well::bodies();
    bodies.extend(near::houses());
    bodies.extend(near::plants());
    bodies.extend(far::houses());
    bodies.extend(far::trees());
    group(&mut bodies);
    // Too large for a group; their shadows fall on themselves.
    bodies.extend(far::hills().into_iter().map(Body::without_shadow));
    let ground = Body::new(Shape::Ground { height: GROUND }, Surface::Meadow);
    bodies.push(ground.without_shadow());
    Contents::new(bodies, Vec::new(), Light::outdoors()).under_sky()
}

/// Brings neighbours together, so that few of the balls around [`GROUP`] bodies are large.
fn group(bodies: &mut [Body]) {
    if bodies.len() <= GROUP {
        return;
    }
    let place = |body: &Body| body.shape.bound(0).0;
    let extent = |axis: fn(DVec3) -> f64| {
        let all = bodies.iter().map(|body| axis(place(body)));
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    let axis: fn(DVec3) -> f64 = if extent(|p| p.x) > extent(|p| p.y) { |p| p.x } else { |p| p.y };
    bodies.sort_by(|a, b| axis(place(a)).total_cmp(&axis(place(b))));
    let (before, after) = bodies.split_at_mut(bodies.len().div_ceil(2).next_multiple_of(GROUP));
    group(before);
    group(after);
}
