//! Polished bodies that mirror each other, what stands around them, and a sharp lamp: what
//! is seen on them moves with the viewer and lies behind their surfaces.

use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec3};

/// Height of the floor.
const FLOOR: f64 = -0.60;

pub(super) fn bodies() -> Vec<Body> {
    let at = |x, y, above: f64| dvec3(x, y, FLOOR + above);
    let polished =
        |shape, colour, reflectance| Body::new(shape, Surface::Mirror { colour, reflectance });
    let matt =
        |center, radius, colour| Body::new(Shape::sphere(center, radius), Surface::Plain(colour));
    vec![
        polished(
            Shape::block(at(0.0, 0.0, -0.05), dvec3(1.0, 1.0, 0.05)),
            dvec3(0.16, 0.17, 0.20),
            0.50,
        ),
        polished(Shape::sphere(at(-0.42, -0.38, 0.46), 0.46), DVec3::splat(0.10), 0.75),
        polished(
            Shape::Ellipsoid { center: at(0.46, -0.42, 0.30), radii: dvec3(0.46, 0.40, 0.30) },
            dvec3(0.40, 0.05, 0.08),
            0.45,
        ),
        polished(
            Shape::Block {
                center: at(0.36, 0.48, 0.42),
                half: dvec3(0.34, 0.22, 0.42),
                turn: DVec2::new(0.8, 0.6),
            },
            dvec3(0.06, 0.10, 0.24),
            0.60,
        ),
        polished(
            Shape::Cylinder { base: at(-0.50, 0.54, 0.0), radius: 0.26, height: 0.95 },
            dvec3(0.30, 0.24, 0.08),
            0.65,
        ),
        matt(at(-0.02, 0.06, 0.12), 0.12, dvec3(0.92, 0.40, 0.08)),
        matt(at(0.04, -0.86, 0.10), 0.10, dvec3(0.10, 0.55, 0.25)),
        matt(at(-0.86, 0.10, 0.10), 0.10, dvec3(0.75, 0.10, 0.35)),
        matt(at(0.84, 0.08, 0.12), 0.12, dvec3(0.95, 0.78, 0.20)),
        matt(at(-0.06, 0.84, 0.11), 0.11, dvec3(0.15, 0.35, 0.80)),
    ]
}
