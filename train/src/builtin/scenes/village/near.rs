//! What stands 3 to 8 units away.

use super::house::House;
use super::{GROUND, WOOD};
use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec2, dvec3};

const LEAVES: Surface = Surface::Mottled {
    cell: 0.16,
    colours: [DVec3::new(0.12, 0.28, 0.08), DVec3::new(0.46, 0.58, 0.20)],
};

/// 5 to 8 units away.
pub(super) fn houses() -> Vec<Body> {
    let plaster = |a: DVec3| Surface::Mottled { cell: 0.3, colours: [a * 0.86, a] };
    let slate = Surface::Stripes {
        period: 0.24,
        colours: [dvec3(0.34, 0.36, 0.42), dvec3(0.24, 0.25, 0.30)],
    };
    let tiles = Surface::Stripes {
        period: 0.2,
        colours: [dvec3(0.60, 0.24, 0.16), dvec3(0.42, 0.15, 0.12)],
    };
    let timber = Surface::Stripes {
        period: 0.5,
        colours: [dvec3(0.88, 0.84, 0.74), dvec3(0.50, 0.36, 0.26)],
    };
    let house = |at: [f64; 2], half: [f64; 2], heights, turn: [f64; 2], walls, roof| House {
        at: at.into(),
        half: half.into(),
        heights,
        turn: turn.into(),
        walls,
        roof,
    };
    let cream = plaster(dvec3(0.94, 0.86, 0.66));
    let salmon = plaster(dvec3(0.80, 0.52, 0.42));
    let white = plaster(dvec3(0.90, 0.90, 0.88));
    let blue = plaster(dvec3(0.60, 0.70, 0.78));
    [
        house([6.2, 1.5], [1.1, 0.8], [1.2, 0.8], [0.28, 0.96], cream, tiles),
        house([2.6, 6.0], [1.3, 0.9], [1.5, 0.9], [0.96, -0.28], timber, slate),
        house([-4.0, 5.2], [1.0, 0.8], [1.1, 0.9], [0.6, 0.8], salmon, slate),
        house([-6.9, -0.8], [1.2, 0.9], [1.4, 0.8], [0.0, 1.0], white, tiles),
        house([-3.2, -6.3], [1.1, 0.8], [1.2, 1.0], [0.8, -0.6], timber, tiles),
        house([4.6, -5.0], [1.2, 0.8], [1.3, 0.8], [0.8, 0.6], blue, slate),
    ]
    .iter()
    .flat_map(|house| house.shell().into_iter().chain(house.details()))
    .collect()
}

/// Trees 5 to 7 units away, and bushes 3 units away, lower than any camera.
pub(super) fn plants() -> Vec<Body> {
    let ball = |p: DVec2, above, radii| {
        Body::new(Shape::Ellipsoid { center: p.extend(GROUND + above), radii }, LEAVES)
    };
    let tree = |p: DVec2| {
        let base = p.extend(GROUND);
        [
            Body::new(Shape::Cylinder { base, radius: 0.11, height: 1.2 }, WOOD),
            ball(p, 1.5, dvec3(0.66, 0.66, 0.6)),
            ball(p + dvec2(0.12, -0.1), 2.1, dvec3(0.46, 0.46, 0.5)),
        ]
    };
    let trees = [(4.9, 4.0), (-1.0, 5.5), (-5.6, 2.4), (-5.0, -3.6), (0.9, -5.6), (6.4, -1.9)];
    let bushes = [(2.4, 1.9), (0.4, 3.1), (-2.7, 1.3), (-2.9, -0.9), (-1.2, -2.8), (1.9, -2.3)];
    let bush = |(x, y)| ball(dvec2(x, y), 0.12, dvec3(0.26, 0.24, 0.20));
    let trees = trees.into_iter().flat_map(|(x, y)| tree(dvec2(x, y)));
    trees.chain(bushes.into_iter().map(bush)).collect()
}
