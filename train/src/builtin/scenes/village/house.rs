//! Houses, near and far.

use super::{GROUND, WOOD};
use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, dvec2, dvec3};

/// A house: where its middle is, half its length and width, and how it is turned.
pub(super) struct House {
    pub(super) at: DVec2,
    pub(super) half: DVec2,
    /// Height of its walls, and of its roof above.
    pub(super) heights: [f64; 2],
    /// The unit vector along its ridge.
    pub(super) turn: DVec2,
    pub(super) walls: Surface,
    pub(super) roof: Surface,
}

impl House {
    /// Walls and roof.
    pub(super) fn shell(&self) -> [Body; 2] {
        let Self { at, half, heights: [walls, roof], turn, .. } = *self;
        let center = at.extend(GROUND + 0.5 * walls);
        let block = Shape::Block { center, half: half.extend(0.5 * walls), turn };
        let base = at.extend(GROUND + walls);
        let gable = Shape::Gable { base, half: half * 1.15, height: roof, turn };
        [Body::new(block, self.walls), Body::new(gable, self.roof)]
    }

    /// A chimney, and a door and windows on both long sides.
    pub(super) fn details(&self) -> Vec<Body> {
        let Self { at, half, heights: [walls, roof], turn, .. } = *self;
        let block = |x: f64, y: f64, z: f64, half, surface| {
            let center = (at + turn.rotate(dvec2(x, y))).extend(GROUND + z);
            Body::new(Shape::Block { center, half, turn }, surface)
        };
        let brick = Surface::Checks {
            side: 0.09,
            colours: [dvec3(0.58, 0.28, 0.20), dvec3(0.46, 0.22, 0.17)],
        };
        let (chimney, pane) = (dvec3(0.11, 0.11, 0.35), dvec3(0.16, 0.02, 0.18));
        let glass = Surface::Plain(dvec3(0.16, 0.22, 0.30));
        let mut bodies = vec![block(0.5 * half.x, 0.25 * half.y, walls + roof, chimney, brick)];
        for side in [-half.y, half.y] {
            bodies.push(block(0.0, side, 0.36, dvec3(0.19, 0.025, 0.36), WOOD));
            for x in [-0.6 * half.x, 0.6 * half.x] {
                bodies.push(block(x, side, 0.62 * walls, pane, glass));
            }
        }
        bodies
    }
}
