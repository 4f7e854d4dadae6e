//! The still life itself.

use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3};

/// Height of the board's top, on which everything stands.
const TABLE: f64 = -0.60;
/// The wires' radius: 0.7 to 1.5 pixels across from every camera.
pub(in crate::builtin) const WIRE_RADIUS: f64 = 0.003_6;

/// Everything in the scene.
pub(in crate::builtin) fn bodies() -> Vec<Body> {
    let at = |x, y, above: f64| DVec3::new(x, y, TABLE + above);
    let mut bodies = vec![
        Body::new(Shape::block(at(0.0, 0.0, -0.06), DVec3::new(0.84, 0.84, 0.06)), Surface::Board),
        Body::new(
            Shape::Block {
                center: at(-0.40, 0.38, 0.58),
                half: DVec3::new(0.25, 0.25, 0.58),
                turn: DVec2::new(0.8, 0.6),
            },
            Surface::Stone,
        ),
        Body::new(glazed(), Surface::Glaze),
        Body::new(Shape::sphere(at(-0.56, -0.52, 0.27), 0.27), Surface::Marble),
        Body::new(
            Shape::Cylinder { base: at(0.06, 0.50, 0.0), radius: 0.15, height: 0.30 },
            Surface::Bands,
        ),
        Body::new(
            Shape::sphere(at(0.06, 0.50, 0.43), 0.13),
            Surface::Plain(DVec3::new(0.05, 0.16, 0.55)),
        ),
    ];
    bodies.extend(vase_with_flowers(at(0.50, 0.52, 0.0)));
    bodies
}

/// The glazed pebble: flat enough for its highlight to run far over it.
pub(in crate::builtin) fn glazed() -> Shape {
    Shape::Ellipsoid {
        center: DVec3::new(0.27, -0.34, TABLE + 0.25),
        radii: DVec3::new(0.58, 0.50, 0.25),
    }
}

/// A white vase standing on `foot`, with seven flowers on wires.
fn vase_with_flowers(foot: DVec3) -> Vec<Body> {
    const RADIUS: f64 = 0.17;
    const HEIGHT: f64 = 0.70;
    const YELLOW: DVec3 = DVec3::new(0.98, 0.72, 0.08);
    const ORANGE: DVec3 = DVec3::new(0.93, 0.36, 0.06);
    const PINK: DVec3 = DVec3::new(0.80, 0.10, 0.36);
    // Where each flower is from the vase's mouth, its radius and its colour.
    const FLOWERS: [(DVec3, f64, DVec3); 7] = [
        (DVec3::new(0.02, 0.03, 0.80), 0.070, YELLOW),
        (DVec3::new(0.34, 0.12, 0.64), 0.060, ORANGE),
        (DVec3::new(0.10, 0.36, 0.60), 0.055, PINK),
        (DVec3::new(-0.26, 0.24, 0.68), 0.065, YELLOW),
        (DVec3::new(-0.40, -0.06, 0.54), 0.055, ORANGE),
        (DVec3::new(-0.12, -0.36, 0.66), 0.060, PINK),
        (DVec3::new(0.24, -0.30, 0.56), 0.055, YELLOW),
    ];
    let vase = Shape::Cylinder { base: foot, radius: RADIUS, height: HEIGHT };
    let mouth = foot + DVec3::new(0.0, 0.0, HEIGHT - 0.02);
    let mut bodies = vec![Body::new(vase, Surface::White)];
    for (offset, radius, colour) in FLOWERS {
        let head = mouth + offset;
        let stem = Shape::Wire { from: mouth, to: head, radius: WIRE_RADIUS };
        bodies.push(Body::new(stem, Surface::Wire));
        bodies.push(Body::new(Shape::sphere(head, radius), Surface::Plain(colour)));
    }
    bodies
}
