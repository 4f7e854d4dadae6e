use super::*;

/// Segments through the box and past it.
fn segments(n: usize, seed: u32) -> Vec<[[f32; 3]; 2]> {
    let mut random = Random(seed);
    (0..n).map(|_| [random.point(1.5), random.point(1.5)]).collect()
}

/// Where a segment enters the box [-1, 1]³ and leaves it, parts of its length.
fn inside([a, b]: [[f32; 3]; 2]) -> [f64; 2] {
    let (mut t0, mut t1) = (0.0, 1.0f64);
    for axis in 0..3 {
        let (o, d) = (f64::from(a[axis]), f64::from(b[axis]) - f64::from(a[axis]));
        let (p, q) = ((-1.0 - o) / d, (1.0 - o) / d);
        (t0, t1) = (p.min(q).max(t0), p.max(q).min(t1));
    }
    [t0, t1.max(t0)]
}

fn length([a, b]: [[f32; 3]; 2]) -> f64 {
    (0..3).map(|i| (f64::from(b[i]) - f64::from(a[i])).powi(2)).sum::<f64>().sqrt()
}

fn ask(probe: &Probe<'_>, scratch: &mut [f32], segments: &[[[f32; 3]; 2]]) -> Vec<f32> {
    let here = |segment: &[[f32; 3]; 2]| segment.map(|p| probe.similarity().to_dataset(p));
    let segments: Vec<_> = segments.iter().map(here).collect();
    let mut out = vec![f32::NAN; segments.len()];
    probe.segment_transmittance(&segments, scratch, &mut out).unwrap();
    out
}

/// Beer and Lambert: exp(-sigma length).
#[test]
fn even_fog() {
    let segments = segments(1200, 6);
    for kind in kinds() {
        // The midpoint rule is exact however long steps are.
        let mut model = fog(&kind, 0.0, 0.7);
        model.sampling.step = 0.3;
        each_probe(&model, |probe, scratch| {
            for (found, segment) in ask(probe, scratch, &segments).iter().zip(&segments) {
                let [t0, t1] = inside(*segment);
                let expected = (-0.7f64.exp() * (t1 - t0) * length(*segment)).exp();
                assert_close(*found, expected as f32, 3e-5, 0.0);
            }
        });
    }
}

/// `∫ exp(a z + b) dt` is `length (exp(a z1 + b) - exp(a z0 + b)) / (a (z1 - z0))`. Steps of
/// 0.01 are off by a part in 100,000 of it.
#[test]
fn fog_that_thickens() {
    let segments = segments(600, 7);
    let (slope, log) = (1.5, -0.5);
    for kind in kinds() {
        each_probe(&fog(&kind, 1.5, -0.5), |probe, scratch| {
            for (found, segment) in ask(probe, scratch, &segments).iter().zip(&segments) {
                let [t0, t1] = inside(*segment);
                let [z0, z1] = [t0, t1]
                    .map(|t| f64::from(segment[0][2]) * (1.0 - t) + f64::from(segment[1][2]) * t);
                let mean = match slope * (z1 - z0) {
                    rise if rise.abs() < 1e-6 => (slope * z0 + log).exp(),
                    rise => ((slope * z1 + log).exp() - (slope * z0 + log).exp()) / rise,
                };
                let optical = mean * (t1 - t0) * length(*segment);
                assert_close(*found, (-optical).exp() as f32, (3e-5 * optical) as f32 + 1e-5, 0.0);
            }
        });
    }
}

/// What passes a way passes its two halves one after the other. The walls of cells, of
/// which a way has up to twenty, may each be half a step (σ δ/2 = 0.005 at most) farther.
#[test]
fn ways_in_two_halves() {
    let mut random = Random(8);
    let whole = segments(400, 8);
    let middles: Vec<[f32; 3]> = whole
        .iter()
        .map(|[a, b]| {
            let t = 0.5 + 0.5 * random.signed();
            [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]))
        })
        .collect();
    let first: Vec<_> = whole.iter().zip(&middles).map(|([a, _], m)| [*a, *m]).collect();
    let second: Vec<_> = whole.iter().zip(&middles).map(|([_, b], m)| [*m, *b]).collect();
    for kind in kinds() {
        let cells = tabled(occupancy(|[x, y, z]| (x / 4 + y / 4 + z / 4) % 2 == 0));
        for (occupancy, tolerance) in [(None, 1e-4), (Some(cells), 0.06)] {
            let mut model = Model { occupancy, ..fog(&kind, 1.0, 0.5) };
            model.sampling.step = if occupancy.is_some() { 0.002 } else { 0.01 };
            each_probe(&model, |probe, scratch| {
                let [whole, first, second] =
                    [&whole, &first, &second].map(|ways| ask(probe, scratch, ways));
                for ((whole, first), second) in whole.iter().zip(first).zip(second) {
                    assert_close(first * second, *whole, tolerance, 0.0);
                }
            });
        }
    }
}

/// Through a plate three cells thick, at every angle: within half a step at either wall.
#[test]
fn a_plate() {
    let mut random = Random(9);
    for kind in kinds() {
        let model = Model {
            occupancy: Some(occupancy(|[.., z]| (20..23).contains(&z))),
            ..fog(&kind, 0.0, 2.0)
        };
        let ways: Vec<_> = (0..500)
            .map(|_| {
                let [x, y, _] = random.point(0.9);
                let [x2, y2, _] = random.point(0.9);
                [[x, y, 0.9], [x2, y2, -0.9]]
            })
            .collect();
        each_probe(&model, |probe, scratch| {
            for (found, way) in ask(probe, scratch, &ways).iter().zip(&ways) {
                let thickness = length(*way) * f64::from(wall(23) - wall(20)) / 1.8;
                let optical = -f64::from(*found).ln();
                let off = optical / 2f64.exp() - thickness;
                assert!(off.abs() <= 0.01 + 1e-4, "off by {off}");
            }
        });
    }
}

#[test]
fn ways_without_length_and_past_everything() {
    for kind in kinds() {
        each_probe(&fog(&kind, 0.0, 5.0), |probe, scratch| {
            let ways = [
                [[0.3; 3], [0.3; 3]],
                [[2.0, 0.0, 0.0], [2.0, 5.0, 0.0]],
                [[-5.0, 0.5, 0.5], [-1.5, 0.5, 0.5]],
                [[-3.0, 1.5, 0.0], [3.0, 1.5, 0.0]],
                [[0.0; 3], [0.0, 0.0, 1e9]],
            ];
            let found = ask(probe, scratch, &ways);
            assert_eq!(found[..4], [1.0; 4]);
            assert_eq!(found[4], 0.0);
        });
    }
}
