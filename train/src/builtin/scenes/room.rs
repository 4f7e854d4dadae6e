//! A furnished room, seen from inside: every ray ends at a surface.

use crate::builtin::contents::{Body, Contents};
use crate::builtin::shading::Light;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec2, DVec3, dvec3};

/// Half the room's length, width and height.
const HALF: DVec3 = DVec3::new(1.9, 1.7, 1.1);
/// Half the walls' thickness.
const WALL: f64 = 0.05;
/// The box that holds room and walls: smallest and largest corner.
pub(in crate::builtin) const BOX: [[f32; 3]; 2] = [[-2.0, -1.8, -1.2], [2.0, 1.8, 1.2]];

const OAK: Surface = Surface::Stripes {
    period: 0.11,
    colours: [DVec3::new(0.62, 0.45, 0.28), DVec3::new(0.50, 0.34, 0.20)],
};
const LINEN: Surface = Surface::Mottled {
    cell: 0.10,
    colours: [DVec3::new(0.26, 0.36, 0.52), DVec3::new(0.46, 0.56, 0.68)],
};

pub(super) fn contents() -> Contents {
    let mut bodies = walls();
    bodies.extend(pictures());
    bodies.extend(sofa());
    bodies.extend(table());
    bodies.extend(shelf());
    bodies.extend(lamp());
    Contents::new(bodies, Vec::new(), Light::indoors())
}

/// Floor, ceiling and four walls. They cast no shadow: the light comes from outside.
fn walls() -> Vec<Body> {
    let floor =
        Surface::Checks { side: 0.32, colours: [dvec3(0.80, 0.74, 0.64), dvec3(0.46, 0.36, 0.30)] };
    let paper = |a, b| Surface::Mottled { cell: 0.24, colours: [a, b] };
    let ceiling = paper(dvec3(0.92, 0.92, 0.90), dvec3(0.78, 0.80, 0.82));
    let stripes = Surface::Stripes {
        period: 0.30,
        colours: [dvec3(0.88, 0.84, 0.66), dvec3(0.70, 0.76, 0.62)],
    };
    let sides = [
        (-DVec3::Z, floor),
        (DVec3::Z, ceiling),
        (-DVec3::X, paper(dvec3(0.84, 0.62, 0.46), dvec3(0.66, 0.42, 0.34))),
        (DVec3::X, stripes),
        (-DVec3::Y, paper(dvec3(0.52, 0.66, 0.70), dvec3(0.72, 0.82, 0.82))),
        (DVec3::Y, paper(dvec3(0.78, 0.74, 0.84), dvec3(0.56, 0.52, 0.68))),
    ];
    sides
        .into_iter()
        .map(|(outward, surface)| {
            // Wide enough to close the corners.
            let across = DVec3::ONE - outward.abs();
            let half = (HALF + 2.0 * WALL) * across + WALL * outward.abs();
            Body::new(Shape::block(outward * (HALF + WALL), half), surface).without_shadow()
        })
        .collect()
}

/// A picture on each wall.
fn pictures() -> Vec<Body> {
    let checks = |a, b| Surface::Checks { side: 0.13, colours: [a, b] };
    let flat = 0.03;
    [
        (dvec3(-HALF.x, 0.3, 0.25), dvec3(flat, 0.40, 0.28), Surface::Marble),
        (
            dvec3(HALF.x, -0.4, 0.30),
            dvec3(flat, 0.32, 0.32),
            checks(dvec3(0.95, 0.80, 0.20), dvec3(0.70, 0.12, 0.12)),
        ),
        (dvec3(0.5, -HALF.y, 0.30), dvec3(0.45, flat, 0.30), Surface::Bands),
        (
            dvec3(-0.6, HALF.y, 0.35),
            dvec3(0.30, flat, 0.40),
            checks(dvec3(0.10, 0.30, 0.45), dvec3(0.90, 0.90, 0.85)),
        ),
    ]
    .into_iter()
    .map(|(center, half, surface)| Body::new(Shape::block(center, half), surface))
    .collect()
}

/// Along the wall at −x.
fn sofa() -> Vec<Body> {
    let floor = -HALF.z;
    let block = |x, y, z, half| Body::new(Shape::block(dvec3(x, y, floor + z), half), LINEN);
    vec![
        block(-1.55, 0.2, 0.18, dvec3(0.33, 0.75, 0.18)),
        block(-1.80, 0.2, 0.50, dvec3(0.08, 0.75, 0.16)),
        block(-1.55, -0.62, 0.30, dvec3(0.33, 0.09, 0.30)),
        block(-1.55, 1.02, 0.30, dvec3(0.33, 0.09, 0.30)),
        Body::new(
            Shape::Ellipsoid {
                center: dvec3(-1.52, 0.55, floor + 0.50),
                radii: dvec3(0.12, 0.20, 0.17),
            },
            Surface::Plain(dvec3(0.85, 0.45, 0.15)),
        ),
    ]
}

/// A low one in the middle, with a bowl and a ball on it.
fn table() -> Vec<Body> {
    let floor = -HALF.z;
    let corner = |x, y| Shape::Cylinder { base: dvec3(x, y, floor), radius: 0.04, height: 0.3 };
    let mut bodies = vec![
        Body::new(Shape::block(dvec3(0.0, 0.0, floor + 0.33), dvec3(0.42, 0.32, 0.03)), OAK),
        Body::new(
            Shape::Cylinder { base: dvec3(-0.15, 0.05, floor + 0.36), radius: 0.13, height: 0.10 },
            Surface::Bands,
        ),
        Body::new(
            Shape::sphere(dvec3(0.20, -0.08, floor + 0.46), 0.10),
            Surface::Plain(dvec3(0.70, 0.10, 0.14)),
        ),
    ];
    let corners = [(-0.36, -0.26), (-0.36, 0.26), (0.36, -0.26), (0.36, 0.26)];
    bodies.extend(corners.map(|(x, y)| Body::new(corner(x, y), OAK)));
    bodies
}

/// Boards with boxes on them, at the wall at +y.
fn shelf() -> Vec<Body> {
    const COLOURS: [DVec3; 3] =
        [DVec3::new(0.75, 0.20, 0.18), DVec3::new(0.18, 0.42, 0.36), DVec3::new(0.90, 0.74, 0.34)];
    let mut bodies = Vec::new();
    for i in 0..3 {
        let z = -HALF.z + 0.30 + 0.42 * i as f64;
        let board = Shape::block(dvec3(1.0, 1.54, z), dvec3(0.5, 0.14, 0.02));
        bodies.push(Body::new(board, OAK));
        for (k, colour) in COLOURS.into_iter().enumerate() {
            let half = dvec3(0.05 + 0.02 * k as f64, 0.10, 0.10 + 0.03 * ((k + i) % 3) as f64);
            let x = 0.66 + 0.26 * k as f64 + 0.05 * i as f64;
            let center = dvec3(x, 1.55, z + 0.02 + half.z);
            bodies.push(Body::new(Shape::block(center, half), Surface::Plain(colour)));
        }
    }
    bodies
}

/// A stool and a floor lamp, at the wall at −y.
fn lamp() -> Vec<Body> {
    let floor = -HALF.z;
    let white = Surface::Plain(dvec3(0.97, 0.93, 0.82));
    let metal = Surface::Plain(dvec3(0.25, 0.25, 0.28));
    vec![
        Body::new(
            Shape::Cylinder { base: dvec3(1.45, -1.35, floor), radius: 0.16, height: 0.04 },
            metal,
        ),
        Body::new(
            Shape::Cylinder { base: dvec3(1.45, -1.35, floor), radius: 0.025, height: 1.3 },
            metal,
        ),
        Body::new(Shape::sphere(dvec3(1.45, -1.35, floor + 1.42), 0.20), white),
        Body::new(
            Shape::Block {
                center: dvec3(-0.9, -1.35, floor + 0.22),
                half: dvec3(0.22, 0.22, 0.22),
                turn: DVec2::new(0.8, 0.6),
            },
            Surface::Mottled {
                cell: 0.08,
                colours: [dvec3(0.86, 0.80, 0.70), dvec3(0.44, 0.30, 0.24)],
            },
        ),
    ]
}
