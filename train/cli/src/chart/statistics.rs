//! Statistics of repeated timings: median, confidence interval and spread.

use pocketnerf_train::metrics::quantile;
use pocketnerf_train::random::Random;

/// Resamples of the bootstrap.
const RESAMPLES: usize = 2000;
/// Its random seed: the same timings give the same interval.
const SEED: u64 = 0x0b00_75e7;

/// The summary of repeated timings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The median.
    pub median: f64,
    /// The 95 % interval of the median by the percentile bootstrap (Efron 1979):
    /// lower and upper end.
    pub interval: [f64; 2],
    /// From the first to the third quartile, as a share of the median.
    pub spread: f64,
}

impl Summary {
    /// `None` without timings.
    #[must_use]
    pub fn of(timings: &[f64]) -> Option<Self> {
        let mut sorted = timings.to_vec();
        sorted.sort_by(f64::total_cmp);
        let median = quantile(&sorted, 0.5)?;
        let [low, high] = [0.25, 0.75].map(|q| quantile(&sorted, q).unwrap_or(median));
        Some(Self { median, interval: bootstrap(&sorted), spread: (high - low) / median })
    }
}

/// The interval that holds 95 % of the medians of resampled timings.
fn bootstrap(timings: &[f64]) -> [f64; 2] {
    let mut random = Random::new(SEED, [timings.len() as u64, 0, 0]);
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| {
            let draw = |_| timings[random.below(timings.len())];
            let mut resample: Vec<f64> = (0..timings.len()).map(draw).collect();
            resample.sort_by(f64::total_cmp);
            quantile(&resample, 0.5)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    [0.025, 0.975].map(|q| quantile(&medians, q).unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hand_computed() {
        assert_eq!(Summary::of(&[]), None);
        let one = Summary { median: 3.0, interval: [3.0; 2], spread: 0.0 };
        assert_eq!(Summary::of(&[3.0]), Some(one));
        let five = Summary::of(&[5.0, 1.0, 4.0, 2.0, 3.0]).unwrap();
        assert_eq!((five.median, five.spread), (3.0, 2.0 / 3.0));
        assert_eq!(quantile(&[1.0, 2.0, 4.0, 8.0], 0.5), Some(3.0));
    }

    #[test]
    fn an_interval_holds_the_true_median_about_as_often_as_it_says() {
        // 400 series of 15 values of a skewed distribution with median 0.25.
        let mut random = Random::new(1, [0; 3]);
        let mut draw = || f64::from(random.next_f32()).powi(2);
        let held = (0..400)
            .filter(|_| {
                let series: Vec<f64> = (0..15).map(|_| draw()).collect();
                let [low, high] = Summary::of(&series).unwrap().interval;
                low <= 0.25 && 0.25 <= high
            })
            .count();
        assert!((370..=400).contains(&held), "{held} of 400");
    }
}
