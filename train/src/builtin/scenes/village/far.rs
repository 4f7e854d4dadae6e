//! What stands 12 to 200 units away, all around.

use super::GROUND;
use super::house::House;
use crate::builtin::contents::Body;
use crate::builtin::noise::random;
use crate::builtin::scenes::GOLDEN_TURN;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec2, dvec3};

/// All around, each `growth` times as far away as the one before: number, place and the
/// direction there.
fn around(n: u32, mut distance: f64, growth: f64) -> impl Iterator<Item = (u32, DVec2, DVec2)> {
    let mut direction = DVec2::X;
    (0..n).map(move |i| {
        direction = GOLDEN_TURN.rotate(direction);
        distance *= growth;
        (i, direction * distance, direction)
    })
}

/// 20 to 70 units away.
pub(super) fn houses() -> Vec<Body> {
    const WALLS: [DVec3; 3] =
        [DVec3::new(0.92, 0.88, 0.80), DVec3::new(0.82, 0.62, 0.46), DVec3::new(0.72, 0.76, 0.80)];
    const ROOFS: [DVec3; 2] = [DVec3::new(0.56, 0.24, 0.18), DVec3::new(0.34, 0.34, 0.40)];
    around(28, 19.0, 1.048)
        .flat_map(|(i, at, direction)| {
            let number = |what| random(i, what, 41);
            let house = House {
                at,
                half: dvec2(1.6 + 0.4 * number(0), 1.1 + 0.2 * number(1)),
                heights: [1.6 + 0.5 * number(2), 1.2],
                turn: dvec2(0.8, 0.6).rotate(direction),
                walls: Surface::Plain(WALLS[i as usize % 3]),
                roof: Surface::Plain(ROOFS[i as usize % 2]),
            };
            house.shell()
        })
        .collect()
}

/// 12 to 80 units away.
pub(super) fn trees() -> Vec<Body> {
    let leaves =
        Surface::Mottled { cell: 0.7, colours: [dvec3(0.14, 0.28, 0.12), dvec3(0.40, 0.50, 0.24)] };
    // Turned against the houses.
    let turn = dvec2(0.28, 0.96);
    around(48, 11.5, 1.041)
        .map(|(i, at, _)| {
            let width = 1.1 + 0.3 * random(i, 0, 42);
            let height = 1.5 + 0.4 * random(i, 1, 42);
            let center = turn.rotate(at).extend(GROUND + 0.9 * height);
            Body::new(Shape::Ellipsoid { center, radii: dvec3(width, width, height) }, leaves)
        })
        .collect()
}

/// 110 to 200 units away, bluish.
pub(super) fn hills() -> Vec<Body> {
    around(13, 105.0, 1.048)
        .map(|(i, at, _)| {
            let share = f64::from(i) / 12.0;
            let radii = dvec3(
                30.0 + 8.0 * random(i, 0, 43),
                30.0 + 8.0 * random(i, 1, 43),
                11.0 + 12.0 * share + 3.0 * random(i, 2, 43),
            );
            let green = dvec3(0.38, 0.50, 0.36).lerp(dvec3(0.52, 0.62, 0.68), share);
            let surface = Surface::Mottled { cell: 7.0, colours: [green * 0.8, green * 1.08] };
            Body::new(Shape::Ellipsoid { center: at.extend(GROUND), radii }, surface)
        })
        .collect()
}
