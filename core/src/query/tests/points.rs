use super::*;
use crate::query::normal;

#[test]
fn density_of_fog() {
    let mut random = Random(1);
    // Some outside.
    let points: Vec<[f32; 3]> = (0..2500).map(|_| random.point(1.2)).collect();
    let is_inside = |p: &[f32; 3]| p.iter().all(|v| v.abs() <= 1.0);
    for kind in kinds() {
        let mut model = fog(&kind, 1.5, -0.5);
        for cells in [None, Some(occupancy(|[x, y, z]| (x + y + z) % 3 == 0))] {
            model.occupancy = cells;
            let expected = points.iter().map(|p| {
                let u = model.space.unit_map().apply(*p);
                let occupied = cells.is_none_or(|cells| cells.at(u));
                if is_inside(p) && occupied { (1.5 * p[2] - 0.5).exp() } else { 0.0 }
            });
            let expected: Vec<f32> = expected.collect();
            each_probe(&model, |probe, scratch| {
                let similarity = *probe.similarity();
                let asked: Vec<_> = points.iter().map(|p| similarity.to_dataset(*p)).collect();
                let mut found = vec![f32::NAN; points.len()];
                probe.density(&asked, scratch, &mut found).unwrap();
                // Rounding may take points across a wall on their way there and back.
                let mut apart = 0;
                for ((found, expected), p) in found.iter().zip(&expected).zip(&asked) {
                    assert_eq!(*found > 0.0, probe.occupied(*p));
                    if (*found > 0.0) == (*expected > 0.0) {
                        assert_close(found * similarity.scale, *expected, 1e-5, 0.0);
                    } else {
                        apart += 1;
                    }
                }
                let is_same = similarity == Similarity::IDENTITY;
                assert!(apart <= if is_same { 0 } else { 2 }, "{apart} points across walls");
            });
        }
    }
}

/// Slope, height and turned axes: differences of h = 1/32 are off by (slope h)²/6.
#[test]
fn gradients_of_fog() {
    let mut random = Random(2);
    let points: Vec<[f32; 3]> = (0..300).map(|_| random.point(0.95)).collect();
    for kind in kinds() {
        let model = fog(&kind, 1.5, -0.5);
        each_probe(&model, |probe, scratch| {
            let similarity = *probe.similarity();
            let asked: Vec<_> = points.iter().map(|p| similarity.to_dataset(*p)).collect();
            let mut found = vec![[f32::NAN; 3]; points.len()];
            probe.density_gradient(&asked, scratch, &mut found).unwrap();
            let up = similarity.rotation.map(|row| row[2]);
            for (found, p) in found.iter().zip(&points) {
                let slope = 1.5 * (1.5 * p[2] - 0.5).exp() / similarity.scale.powi(2);
                for (found, up) in found.iter().zip(up) {
                    assert_close(*found, slope * up, 5e-4, 2e-4 * slope);
                }
                for (found, up) in normal(*found).iter().zip(up) {
                    assert_close(*found, -up, 0.0, 3e-4);
                }
            }
            assert_close(probe.gradient_step(), similarity.scale / 32.0, 1e-6, 0.0);
        });
    }
}

/// Walls that occupancy makes have no slope, nor do faces of the box: one-sided there.
#[test]
fn gradients_at_walls() {
    for kind in kinds() {
        let model =
            Model { occupancy: Some(occupancy(|[x, ..]| x % 2 == 0)), ..fog(&kind, 0.0, 2.0) };
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL).unwrap();
        let mut scratch = vec![0.0; probe.scratch_len()];
        let points = [[wall(2), 0.1, 0.1], [-1.0; 3], [wall(2).next_down(), 0.1, 0.1], [9.0; 3]];
        let mut found = [[f32::NAN; 3]; 4];
        probe.density_gradient(&points, &mut scratch, &mut found).unwrap();
        assert_eq!(found, [[0.0; 3]; 4]);
        let model = fog(&kind, 1.0, 0.0);
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL).unwrap();
        probe.density_gradient(&[[0.5, 0.5, 1.0]], &mut scratch, &mut found[..1]).unwrap();
        // Half a step away from where it is asked.
        assert_close(found[0][2], (1.0f32 - 1.0 / 64.0).exp(), 1e-3, 0.0);
    }
}

#[test]
fn normals_by_hand() {
    assert_eq!(normal([0.0; 3]), [0.0; 3]);
    assert_eq!(normal([0.0, -2.0, 0.0]), [0.0, 1.0, 0.0]);
    for length in [1e-30f32, 1.0, 1e37] {
        let [x, y, z] = normal([3.0 * length, 0.0, -4.0 * length]);
        assert!((x + 0.6).abs() < 1e-6 && y == 0.0 && (z - 0.8).abs() < 1e-6);
    }
    assert_eq!(normal([f32::NAN, 1.0, 0.0]), [0.0; 3]);
}

/// 1000 points of a milli-unit³ each make a cubic unit: sigma / area particles.
#[test]
fn collisions_by_hand() {
    let mut random = Random(3);
    let points: Vec<[f32; 3]> = (0..1000).map(|_| random.point(0.5)).collect();
    for kind in kinds() {
        let model = fog(&kind, 0.0, core::f32::consts::LN_2);
        each_probe(&model, |probe, scratch| {
            let similarity = *probe.similarity();
            let body: Vec<_> = points.iter().map(|p| similarity.to_dataset(*p)).collect();
            let cube = similarity.scale.powi(3);
            // Sigma 2: the same probability, whatever the unit of length.
            for (area, expected) in [(4.0f32, 0.393_469_34), (2e7, 1e-7), (1e-3, 1.0)] {
                let area = area * similarity.scale * similarity.scale;
                let p = probe.collision_probability(&body, cube / 1000.0, area, scratch).unwrap();
                assert_close(p, expected, 2e-5, 0.0);
            }
            assert_eq!(probe.collision_probability(&body, 0.0, 1.0, scratch), Ok(0.0));
            assert_eq!(probe.collision_probability(&[], 1.0, 1.0, scratch), Ok(0.0));
            let away = [similarity.to_dataset([3.0; 3])];
            assert_eq!(probe.collision_probability(&away, 1.0, 1.0, scratch), Ok(0.0));
        });
    }
}
