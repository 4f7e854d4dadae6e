//! Wires from a quarter of an occupancy cell to two cells across: parallel, fanned out,
//! crossing, and from one plane to another.

use crate::builtin::contents::Body;
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use glam::{DVec3, dvec3};

/// Side of an occupancy cell, of which 128 span the scene.
pub(in crate::builtin) const CELL: f64 = 2.1 / 128.0;
/// The wires' widths in cells, with the colour of each.
pub(in crate::builtin) const WIDTHS: [(f64, DVec3); 4] = [
    (0.25, DVec3::new(0.12, 0.12, 0.14)),
    (0.5, DVec3::new(0.62, 0.14, 0.10)),
    (1.0, DVec3::new(0.10, 0.24, 0.58)),
    (2.0, DVec3::new(0.16, 0.44, 0.18)),
];
/// Half the height of a plane of wires.
const HALF: f64 = 0.80;
/// From one plane to the next.
const APART: f64 = 0.5;

pub(super) fn bodies() -> Vec<Body> {
    let mut bodies = Vec::new();
    for (i, (cells, colour)) in WIDTHS.into_iter().enumerate() {
        let y = (i as f64 - 1.5) * APART;
        let mut string = |from: [f64; 2], to: [f64; 2]| {
            let [from, to] = [from, to].map(|[x, z]| dvec3(x, y, z));
            bodies.extend(wire(from, to, cells * CELL, colour));
        };
        // Upright ones, and three across them.
        for x in [-0.88, -0.74, -0.60, -0.46] {
            string([x, -HALF], [x, HALF]);
        }
        for z in [-0.5, 0.0, 0.5] {
            string([-0.97, z], [-0.37, z]);
        }
        // Lattice: two directions that cross at several angles.
        for x in [-0.28, -0.14, 0.0] {
            string([x, -HALF], [x + 0.26, HALF]);
            string([x + 0.26, -HALF], [x, HALF]);
        }
        // Fan: from parallel to 45 degrees.
        for x in [0.34, 0.54, 0.74, 0.94] {
            string([0.34, -HALF], [x, if x > 0.9 { -0.20 } else { HALF }]);
        }
    }
    // From the finest plane to the widest.
    let [near, far] = [-1.5 * APART, 1.5 * APART];
    for (i, (cells, colour)) in WIDTHS.into_iter().enumerate() {
        let x = -0.75 + 0.5 * i as f64;
        let z = 0.4 - 0.2 * i as f64;
        bodies.extend(wire(dvec3(x, near, z), dvec3(x + 0.1, far, -z), cells * CELL, colour));
    }
    bodies
}

/// A wire `width` across with a bead at each end, which hides that it is open.
fn wire(from: DVec3, to: DVec3, width: f64, colour: DVec3) -> [Body; 3] {
    let bead = |end| Body::new(Shape::sphere(end, width), Surface::Thin(colour));
    let wire = Shape::Wire { from, to, radius: 0.5 * width };
    [Body::new(wire, Surface::Thin(colour)), bead(from), bead(to)]
}
