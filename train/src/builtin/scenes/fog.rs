//! A ball of fog around a solid one, and another fog beside a pillar: what is seen has no
//! surface, and what is behind is seen through it.

use crate::builtin::contents::{Body, Contents};
use crate::builtin::medium::{Matter, Medium};
use crate::builtin::shading::Light;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec3, dvec3};

/// Radius of the fog that holds a ball, and of the one that holds nothing.
const RADII: [f64; 2] = [0.72, 0.42];

pub(super) fn contents() -> Contents {
    let [around, alone] = RADII;
    let bodies = vec![
        Body::new(Shape::sphere(dvec3(-0.30, 0.0, 0.10), 0.24), Surface::Marble),
        Body::new(
            Shape::Cylinder { base: dvec3(0.42, 0.62, -0.85), radius: 0.15, height: 1.5 },
            Surface::Bands,
        ),
    ];
    let fog = |center, radius, sigma, colour| {
        let matter = Matter::Fog { center, radii: DVec3::splat(radius) };
        Medium { matter, sigma, colour }
    };
    let media = vec![
        fog(dvec3(-0.30, 0.0, 0.10), around, 2.6, dvec3(0.70, 0.76, 0.84)),
        fog(dvec3(0.72, -0.46, -0.34), alone, 4.0, dvec3(0.90, 0.62, 0.40)),
    ];
    Contents::new(bodies, media, Light::outdoors())
}
