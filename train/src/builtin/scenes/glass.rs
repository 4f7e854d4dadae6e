//! Tinted glass before the empty background, and things seen through it. Rays go straight
//! on, and edges are darker than faces, as the way through them is longer.

use crate::builtin::contents::{Body, Contents};
use crate::builtin::medium::Medium;
use crate::builtin::shading::Light;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec3};

/// Thickness of a pane.
const PANE: f64 = 0.03;
const RED: DVec3 = DVec3::new(0.86, 0.16, 0.14);
const GREEN: DVec3 = DVec3::new(0.10, 0.62, 0.36);
const BLUE: DVec3 = DVec3::new(0.14, 0.34, 0.84);
const AMBER: DVec3 = DVec3::new(0.92, 0.62, 0.16);

pub(super) fn contents() -> Contents {
    let bodies = vec![
        Body::new(Shape::sphere(dvec3(-0.05, 0.30, -0.10), 0.26), Surface::Marble),
        Body::new(
            Shape::Cylinder { base: dvec3(-0.62, -0.30, -0.75), radius: 0.13, height: 1.2 },
            Surface::Bands,
        ),
        // Inside the glass ball and the glass block.
        Body::new(Shape::sphere(BALL, 0.14), Surface::Plain(dvec3(0.05, 0.16, 0.55))),
        Body::new(
            Shape::block(BLOCK, DVec3::splat(0.10)),
            Surface::Checks {
                side: 0.05,
                colours: [dvec3(0.95, 0.92, 0.85), dvec3(0.30, 0.06, 0.10)],
            },
        ),
    ];
    let media = vec![
        // Three panes one behind another.
        pane(dvec3(-0.05, -0.70, 0.05), [0.46, 0.62], DVec2::X, 0.35, RED),
        pane(dvec3(0.00, -0.38, 0.05), [0.46, 0.62], DVec2::new(0.96, 0.28), 0.45, GREEN),
        pane(dvec3(-0.05, 0.78, 0.05), [0.66, 0.62], DVec2::X, 0.55, BLUE),
        // One at right angles to them.
        pane(dvec3(-0.92, 0.10, 0.05), [0.50, 0.62], DVec2::Y, 0.30, AMBER),
        Medium::glass(Shape::sphere(BALL, 0.30), 0.60, 0.55, AMBER),
        Medium::glass(Shape::block(BLOCK, DVec3::splat(0.24)), 0.48, 0.60, GREEN),
        Medium::glass(
            Shape::Cylinder { base: dvec3(0.84, -0.70, -0.75), radius: 0.18, height: 0.8 },
            0.36,
            0.70,
            BLUE,
        ),
    ];
    Contents::new(bodies, media, Light::outdoors())
}

/// Centres of a glass ball and of a glass block.
const BALL: DVec3 = DVec3::new(0.66, 0.10, 0.42);
const BLOCK: DVec3 = DVec3::new(0.62, 0.22, -0.50);

/// An upright pane around `center`. `half` is half its width and half its height, `turn` the
/// horizontal unit vector along its width, and `alpha` its opacity when looked through at a right
/// angle.
fn pane(center: DVec3, half: [f64; 2], turn: DVec2, alpha: f64, colour: DVec3) -> Medium {
    let half = dvec3(half[0], 0.5 * PANE, half[1]);
    Medium::glass(Shape::Block { center, half, turn }, PANE, alpha, colour)
}
