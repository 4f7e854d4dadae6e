//! Questions whose answers are known: fog of one density or of one slope, cut into balls,
//! walls and panes by occupancy.

extern crate std;
use std::vec;
use std::vec::Vec;

use crate::query::{Probe, Similarity};
use crate::reference::testing::{Kind, SceneBuilder, kinds};
use crate::{Model, Occupancy, SimdLevel, Tuning};

mod clearance;
mod depth;
mod misuse;
mod points;
mod surface;
mod transmittance;

/// A little random generator; deterministic.
struct Random(u32);

impl Random {
    /// Uniform in [-1, 1).
    fn signed(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// A point in the cube [-reach, reach]³.
    fn point(&mut self, reach: f32) -> [f32; 3] {
        [0; 3].map(|_| reach * self.signed())
    }

    /// A point of a ball, spread evenly.
    fn inside(&mut self, center: [f32; 3], radius: f32) -> [f32; 3] {
        loop {
            let p = self.point(1.0);
            if p.iter().map(|v| v * v).sum::<f32>() <= 1.0 {
                return [0, 1, 2].map(|a| center[a] + radius * p[a]);
            }
        }
    }
}

/// In the box [-1, 1]³, sigma is `exp(slope z + log)`.
fn fog(kind: &Kind, slope: f32, log: f32) -> Model<'static> {
    let mut scene = SceneBuilder::new(kind, [slope, 0.0, 0.0], [log, 0.0, 0.0]);
    scene.sampling.near = 0.0;
    scene.sampling.step = 0.01;
    scene.build()
}

/// Cells of the box [-1, 1]³.
const CELLS: u32 = 32;

/// Corner of cell `i`, along an axis of that box.
fn wall(i: u32) -> f32 {
    i as f32 * 2.0 / CELLS as f32 - 1.0
}

/// Occupancy of the cells for which `is` says so; its bytes are never freed.
fn occupancy(is: impl Fn([u32; 3]) -> bool) -> Occupancy<'static> {
    let (mut coarse, mut fine) = (Vec::new(), Vec::<u8>::new());
    let n = CELLS / 8;
    for block in 0..n * n * n {
        let corner = [block % n, block / n % n, block / (n * n)].map(|b| 8 * b);
        let bits: Vec<u8> = (0..64)
            .map(|row| {
                let cell = |x| [corner[0] + x, corner[1] + row % 8, corner[2] + row / 8];
                (0..8).map(|x| u8::from(is(cell(x))) << x).sum()
            })
            .collect();
        if bits.iter().all(|byte| *byte == 0) {
            coarse.extend([0, 0]);
        } else {
            fine.extend(bits);
            coarse.extend((fine.len() as u16 / 64).to_le_bytes());
        }
    }
    Occupancy::new(CELLS, 1, coarse.leak(), fine.leak()).unwrap()
}

/// The same occupancy with its table.
fn tabled(occupancy: Occupancy<'static>) -> Occupancy<'static> {
    let table = vec![0; occupancy.table_len()].leak();
    occupancy.write_table(table).unwrap();
    occupancy.with_table(table).unwrap()
}

/// Coordinates in which nothing is where it was: turned, 4.5 times as large, moved.
fn elsewhere() -> Similarity {
    Similarity {
        scale: 4.5,
        rotation: [[0.6, 0.0, 0.8], [0.64, 0.6, -0.48], [-0.48, 0.8, 0.36]],
        translation: [-20.0, 3.5, 7.25],
    }
}

/// Calls `ask` with probes of every level and size, in both coordinates, and scratch full of
/// NaN.
fn each_probe(model: &Model<'_>, mut ask: impl FnMut(&Probe<'_>, &mut [f32])) {
    for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        for tuning in [Tuning::SMALL, Tuning::FAST] {
            for similarity in [Similarity::IDENTITY, elsewhere()] {
                let probe = Probe::new(model, simd, tuning).unwrap();
                let probe = probe.with_similarity(similarity).unwrap();
                ask(&probe, &mut vec![f32::NAN; probe.scratch_len()]);
            }
        }
    }
}

/// Asserts that two numbers differ by at most a part of the second, and so much.
#[track_caller]
fn assert_close(found: f32, expected: f32, part: f32, most: f32) {
    let apart = (found - expected).abs();
    assert!(apart <= part * expected.abs() + most, "{found}, expected {expected}");
}
