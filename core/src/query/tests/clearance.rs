use super::*;

/// Occupied cells that hold a shell, a rod and a speck.
fn things() -> impl Fn([u32; 3]) -> bool {
    |cell: [u32; 3]| {
        let [x, y, z] = cell.map(|c| wall(c) + 1.0 / CELLS as f32);
        let radius = (x * x + y * y + z * z).sqrt();
        (0.4..0.5).contains(&radius) || (x > 0.8 && y > 0.8) || cell == [2, 27, 4]
    }
}

/// Distance from a point of the model to the nearest occupied cell, by trying all.
fn distance(cells: &[[u32; 3]], p: [f32; 3]) -> f64 {
    let square = |cell: &[u32; 3]| {
        let away = [0, 1, 2].map(|a| {
            let (min, max) = (f64::from(wall(cell[a])), f64::from(wall(cell[a] + 1)));
            (min - f64::from(p[a])).max(f64::from(p[a]) - max).max(0.0)
        });
        away.iter().map(|v| v * v).sum::<f64>()
    };
    cells.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
}

/// Clear is a ball that no occupied cell touches, and no other: 4000 balls, of which
/// rounding, in coordinates 20 times as large as the box, may decide those within 5e-5 of
/// touching. In those that are clear there is no density anywhere.
#[test]
fn balls_are_clear_as_far_as_the_nearest_cell() {
    let is = things();
    let all = (0..CELLS.pow(3)).map(|i| [i % CELLS, i / CELLS % CELLS, i / CELLS / CELLS]);
    let cells: Vec<[u32; 3]> = all.filter(|cell| is(*cell)).collect();
    let mut random = Random(4);
    let balls: Vec<([f32; 3], f32)> = (0..4000)
        .map(|i| {
            let center = random.point(1.3);
            // Many of them just about touch.
            let touching = distance(&cells, center) as f32;
            let radius = match i % 4 {
                0 => touching * (1.0 + 0.001 * random.signed()),
                1 => touching.next_down(),
                _ => 0.4 * random.signed().abs(),
            };
            (center, radius)
        })
        .collect();
    let distances: Vec<f64> = balls.iter().map(|(center, _)| distance(&cells, *center)).collect();
    for kind in kinds() {
        for occupancy in [occupancy(&is), tabled(occupancy(&is))] {
            let model = Model { occupancy: Some(occupancy), ..fog(&kind, 0.0, 1.0) };
            for similarity in [Similarity::IDENTITY, elsewhere()] {
                let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::FAST).unwrap();
                let probe = probe.with_similarity(similarity).unwrap();
                let mut scratch = vec![0.0; probe.scratch_len()];
                let mut clear = 0;
                for ((center, radius), distance) in balls.iter().zip(&distances) {
                    let center = similarity.to_dataset(*center);
                    let is_clear = probe.sphere_clear(center, radius * similarity.scale);
                    let (radius, slack) = (f64::from(*radius), 1e-5 * distance + 5e-5);
                    if is_clear {
                        assert!(radius < *distance + slack, "{center:?} {radius}: {distance}");
                        clear += 1;
                        let ball = f64::from(similarity.scale) * radius;
                        let points: [_; 32] =
                            core::array::from_fn(|_| random.inside(center, ball as f32));
                        let mut sigma = [f32::NAN; 32];
                        probe.density(&points, &mut scratch, &mut sigma).unwrap();
                        assert_eq!(sigma, [0.0; 32], "{center:?} {radius}");
                    } else {
                        assert!(radius > distance - slack, "{center:?} {radius}: {distance}");
                    }
                }
                assert!((1000..3500).contains(&clear), "{clear} of 4000 are clear");
            }
        }
    }
}

/// Balls that just reach a point on a wall, edge or corner of cells, or a rounding beside
/// it, in coordinates that round: where there is density, none of them is clear.
#[test]
fn rounding_never_clears_a_wall() {
    let mut random = Random(5);
    let far_away = Similarity { translation: [3e4, -2e4, 1e3], ..elsewhere() };
    for kind in kinds() {
        let cells = occupancy(|[x, y, z]| x > 20 && (x + y + z) % 2 == 0);
        let model = Model { occupancy: Some(cells), ..fog(&kind, 0.0, 1.0) };
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::FAST).unwrap();
        for similarity in [Similarity::IDENTITY, elsewhere(), far_away] {
            let probe = probe.with_similarity(similarity).unwrap();
            let mut occupied = 0;
            for i in 0..20_000 {
                let p = [0, 1, 2].map(|axis| {
                    let wall = if axis == 0 { wall(21) } else { random.point(1.0)[axis] };
                    [wall, wall.next_up(), wall.next_down()][i % 3]
                });
                let center = [p[0] - 0.3 * random.signed().abs(), p[1], p[2]];
                let [p, center] = [p, center].map(|p| similarity.to_dataset(p));
                let away = [0, 1, 2].map(|a| f64::from(p[a]) - f64::from(center[a]));
                let radius = away.iter().map(|v| v * v).sum::<f64>().sqrt() as f32;
                if probe.occupied(p) {
                    occupied += 1;
                    assert!(!probe.sphere_clear(center, radius.next_up()), "{center:?} {radius}");
                }
            }
            assert!(occupied > 1000, "{occupied} points");
        }
    }
}

#[test]
fn without_occupancy_the_box_is_full() {
    for kind in kinds() {
        let model = fog(&kind, 0.0, -30.0);
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL).unwrap();
        assert!(probe.occupied([0.9; 3]) && !probe.occupied([1.1, 0.0, 0.0]));
        assert!(!probe.sphere_clear([0.5; 3], 1e-3));
        assert!(probe.sphere_clear([2.0, 0.0, 0.0], 0.999));
        assert!(!probe.sphere_clear([2.0, 0.0, 0.0], 1.001));
    }
}

#[test]
fn what_is_not_known_is_not_free() {
    for kind in kinds() {
        for cells in [None, Some(occupancy(|_| false))] {
            let model = Model { occupancy: cells, ..fog(&kind, 0.0, 1.0) };
            let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL).unwrap();
            for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30] {
                assert!(probe.occupied([0.0, bad, 0.0]));
                assert!(!probe.sphere_clear([bad, 0.0, 0.0], 1.0));
                assert!(!probe.sphere_clear([0.0; 3], bad) || bad == 1e30);
            }
            assert!(!probe.sphere_clear([0.0; 3], -1.0));
            assert_eq!(probe.sphere_clear([0.0; 3], 1e30), cells.is_some());
        }
    }
}
