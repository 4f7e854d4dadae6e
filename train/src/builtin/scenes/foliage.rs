//! A small bush: hundreds of leaves on twigs, each a few pixels wide and much less thick.

use super::GOLDEN_TURN;
use crate::builtin::contents::Body;
use crate::builtin::noise::random;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DMat3, DVec2, DVec3, dvec3};

const TWIGS: u32 = 24;
/// Leaves on a twig.
const LEAVES: u32 = 16;
/// A leaf's half length, width and thickness.
const RADII: DVec3 = DVec3::new(0.095, 0.050, 0.003);
/// The trunk's foot and top.
const TRUNK: [DVec3; 2] = [DVec3::new(0.0, 0.0, -0.72), DVec3::new(0.03, -0.02, 0.25)];

pub(super) fn bodies() -> Vec<Body> {
    let pot = Shape::Cylinder { base: dvec3(0.0, 0.0, -1.0), radius: 0.24, height: 0.30 };
    let mut bodies = vec![
        Body::new(pot, Surface::Plain(dvec3(0.62, 0.30, 0.20))),
        twig(TRUNK[0], TRUNK[1], 0.022),
    ];
    let mut around = DVec2::X;
    for i in 0..TWIGS {
        around = GOLDEN_TURN.rotate(around);
        let share = f64::from(i) / f64::from(TWIGS - 1);
        let from = TRUNK[0].lerp(TRUNK[1], 0.30 + 0.70 * share);
        // The higher, the shorter and steeper.
        let reach = 0.80 - 0.45 * share + 0.12 * random(i, 0, 1);
        let rise = 0.12 + 0.62 * share + 0.15 * random(i, 0, 2);
        let to = from + (around * reach).extend(rise);
        bodies.push(twig(from, to, 0.008));
        bodies.extend((0..LEAVES).map(|k| leaf(from, to, [i, k])));
    }
    bodies
}

fn twig(from: DVec3, to: DVec3, radius: f64) -> Body {
    Body::new(Shape::Wire { from, to, radius }, Surface::Thin(dvec3(0.34, 0.24, 0.15)))
}

/// Leaf `k` of twig `i`, that stands out from it.
fn leaf(from: DVec3, to: DVec3, [i, k]: [u32; 2]) -> Body {
    let number = |what| random(i + 1, k + 1, what);
    let along = (to - from).normalize();
    let vector = |what| dvec3(number(what), number(what + 1), number(what + 2));
    let out = (along * 0.5 + vector(10) * 0.9).normalize();
    let normal = out.cross(vector(20) + DVec3::Z).normalize();
    let axes = DMat3::from_cols(out, normal.cross(out), normal);
    let share = 0.25 + 0.78 * (f64::from(k) + 0.5) / f64::from(LEAVES);
    let radii = RADII * (0.8 + 0.2 * number(30));
    let center = from.lerp(to, share) + out * radii.x;
    let light = 0.5 + 0.5 * number(31);
    let colour = dvec3(0.16, 0.42, 0.10).lerp(dvec3(0.58, 0.72, 0.20), light);
    Body::new(Shape::Leaf { center, axes, radii }, Surface::Leaf(colour))
}
