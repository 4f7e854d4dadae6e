//! The still life itself.

use super::shapes::Shape;
use super::surface::Surface;
use glam::{DVec2, DVec3};

/// One thing in the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) shape: Shape,
    pub(super) surface: Surface,
}

/// Height of the board's top, on which everything stands.
const TABLE: f64 = -0.60;
/// The wires' radius: 0.7 to 1.5 pixels across from every camera.
pub(super) const WIRE_RADIUS: f64 = 0.003_6;

/// Everything in the scene.
pub(super) fn bodies() -> Vec<Body> {
    let at = |x, y, above: f64| DVec3::new(x, y, TABLE + above);
    let axes = DVec2::X;
    let mut bodies = vec![
        Body {
            shape: Shape::Block {
                center: at(0.0, 0.0, -0.06),
                half: DVec3::new(0.84, 0.84, 0.06),
                turn: axes,
            },
            surface: Surface::Board,
        },
        Body {
            shape: Shape::Block {
                center: at(-0.40, 0.38, 0.58),
                half: DVec3::new(0.25, 0.25, 0.58),
                turn: DVec2::new(0.8, 0.6),
            },
            surface: Surface::Stone,
        },
        Body { shape: glazed(), surface: Surface::Glaze },
        Body { shape: Shape::sphere(at(-0.56, -0.52, 0.27), 0.27), surface: Surface::Marble },
        Body {
            shape: Shape::Cylinder { base: at(0.06, 0.50, 0.0), radius: 0.15, height: 0.30 },
            surface: Surface::Bands,
        },
        Body {
            shape: Shape::sphere(at(0.06, 0.50, 0.43), 0.13),
            surface: Surface::Plain(DVec3::new(0.05, 0.16, 0.55)),
        },
    ];
    bodies.extend(vase_with_flowers(at(0.50, 0.52, 0.0)));
    bodies
}

/// The glazed pebble: flat enough for its highlight to run far over it.
pub(super) fn glazed() -> Shape {
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
    let mut bodies = vec![Body { shape: vase, surface: Surface::White }];
    for (offset, radius, colour) in FLOWERS {
        let head = mouth + offset;
        let stem = Shape::Wire { from: mouth, to: head, radius: WIRE_RADIUS };
        bodies.push(Body { shape: stem, surface: Surface::Wire });
        bodies.push(Body { shape: Shape::sphere(head, radius), surface: Surface::Plain(colour) });
    }
    bodies
}
