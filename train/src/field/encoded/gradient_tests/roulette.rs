//! The roulette against all samples.

use super::*;

/// The mean of what the roulette passes back is the full gradient.
#[test]
fn roulette_is_unbiased() {
    const ROUNDS: u64 = 1000;
    for shading in SHADINGS {
        let mut step = Step::new(Case { encoding: hash_grid(2), shading, ..ONE_LAYER });
        let (_, samples) = step.run(0.0, 0);
        let full = step.gradient();
        let size: f64 = step.groups().map(|g| g.stats.gradient_size).sum();
        let roulette = (1.5 * size / samples as f64) as f32;
        let mut random = Random::new(6, [0; 3]);
        let ranges = step.layout.ranges();
        // Along the gradient and along random signs.
        let whole = |r| directions(r, &full, &mut random).into_iter().take(2);
        let directions: Vec<Direction> = ranges.iter().flat_map(whole).collect();
        let mut sums = vec![[0.0; 2]; directions.len()];
        let mut kept = 0;
        for luck in 0..ROUNDS {
            kept += step.run(roulette, luck).1;
            let gradient = step.gradient();
            for (sum, direction) in sums.iter_mut().zip(&directions) {
                let error = along(&gradient, direction) - along(&full, direction);
                *sum = [sum[0] + error, sum[1] + error * error];
            }
        }
        let n = ROUNDS as f64;
        let share = kept as f64 / (samples as f64 * n);
        assert!((0.4..0.8).contains(&share), "{share} passed back");
        for ([sum, squares], direction) in sums.into_iter().zip(&directions) {
            let mean = sum / n;
            let standard_error = ((squares / n - mean * mean) / n).sqrt();
            let first = direction[0].0;
            assert!(
                mean.abs() <= 5.0 * standard_error,
                "{shading:?}, from parameter {first} on: off by {mean} ± {standard_error}"
            );
        }
    }
}
