//! In the middle, a unit high: a ring of stones in three courses, and a roof over a bucket.

use super::{GROUND, WOOD};
use crate::builtin::contents::Body;
use crate::builtin::noise::random;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec2, dvec3};

/// Cosine and sine of 15 degrees, half a stone.
const HALF_STONE: DVec2 = DVec2::new(0.965_925_826, 0.258_819_045);
const SHINGLES: Surface = Surface::Stripes {
    period: 0.09,
    colours: [DVec3::new(0.60, 0.24, 0.16), DVec3::new(0.42, 0.15, 0.12)],
};

pub(super) fn bodies() -> Vec<Body> {
    let at = |x, y, above: f64| dvec3(x, y, GROUND + above);
    let wood = |shape| Body::new(shape, WOOD);
    let post = |x| wood(Shape::block(at(x, 0.0, 0.38), dvec3(0.03, 0.035, 0.38)));
    let iron = |from, to, radius| {
        Body::new(Shape::Wire { from, to, radius }, Surface::Thin(dvec3(0.20, 0.20, 0.22)))
    };
    let mut bodies = vec![
        Body::new(
            Shape::Gable {
                base: at(0.0, 0.0, 0.76),
                half: dvec2(0.50, 0.36),
                height: 0.24,
                turn: DVec2::X,
            },
            SHINGLES,
        ),
        post(-0.42),
        post(0.42),
        wood(Shape::block(at(0.0, 0.0, 0.62), dvec3(0.42, 0.03, 0.03))),
        iron(at(0.42, 0.0, 0.62), at(0.54, 0.0, 0.62), 0.012),
        iron(at(0.53, 0.0, 0.63), at(0.53, 0.10, 0.53), 0.012),
        Body::new(Shape::sphere(at(0.53, 0.11, 0.52), 0.024), Surface::Plain(dvec3(0.7, 0.1, 0.1))),
        Body::new(
            Shape::Wire { from: at(0.06, 0.03, 0.62), to: at(0.06, 0.03, 0.50), radius: 0.010 },
            Surface::Thin(dvec3(0.80, 0.72, 0.52)),
        ),
        Body::new(
            Shape::Cylinder { base: at(0.06, 0.03, 0.40), radius: 0.075, height: 0.12 },
            Surface::Bands,
        ),
        // Mortar, and the water in the middle.
        Body::new(
            Shape::Cylinder { base: at(0.0, 0.0, 0.0), radius: 0.33, height: 0.24 },
            Surface::Plain(dvec3(0.16, 0.22, 0.26)),
        ),
    ];
    let mut around = DVec2::X;
    for i in 0..36 {
        // Each course lies half a stone further around.
        let course = i / 12;
        around = HALF_STONE.rotate(around);
        if i % 12 != 0 {
            around = HALF_STONE.rotate(around);
        }
        let light = 0.5 + 0.5 * random(i, 1, 40);
        let grey = dvec3(0.42, 0.40, 0.38).lerp(dvec3(0.76, 0.72, 0.66), light);
        let center = (around * 0.36).extend(GROUND + 0.055 + 0.105 * f64::from(course));
        let half = dvec3(0.055, 0.085, 0.048);
        bodies.push(Body::new(
            Shape::Block { center, half, turn: around },
            Surface::Mottled { cell: 0.05, colours: [grey * 0.8, grey] },
        ));
    }
    bodies
}
