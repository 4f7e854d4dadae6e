//! Means and quantiles: medians, percentiles.

/// The value below which a share `q` of the sorted values lies, interpolated linearly between
/// two of them, as by NumPy's `quantile`. `None` without values.
#[must_use]
pub fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let place = q * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    // The difference of two infinite values is not a number.
    Some(if low == high { low } else { low + (high - low) * place.fract() })
}

/// The median of values in any order; `None` without values.
#[must_use]
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.5)
}

/// The mean; `None` without values.
#[must_use]
pub fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (n, sum) = values.fold((0.0, 0.0), |(n, sum), value| (n + 1.0, sum + value));
    (n > 0.0).then(|| sum / n)
}

#[cfg(test)]
mod tests {
    use super::{mean, median, quantile};

    #[test]
    fn in_any_order() {
        let values = [4.0, -1.0, 2.0, 7.0];
        assert_eq!((median(values.into_iter()), mean(values.into_iter())), (Some(3.0), Some(3.0)));
        assert_eq!((median([].into_iter()), mean([].into_iter())), (None, None));
    }

    #[test]
    fn as_numpy_has_them() {
        // numpy.quantile([20, 21, 23, 30], [0, 0.05, 0.5, 1])
        let sorted = [20.0, 21.0, 23.0, 30.0];
        for (q, expected) in [(0.0, 20.0), (0.05, 20.15), (0.5, 22.0), (1.0, 30.0)] {
            assert!((quantile(&sorted, q).unwrap() - expected).abs() < 1e-12, "{q}");
        }
        assert_eq!(quantile(&[7.0], 0.3), Some(7.0));
        assert_eq!(quantile(&[], 0.3), None);
        // Equal pictures.
        assert_eq!(quantile(&[f64::INFINITY; 3], 0.25), Some(f64::INFINITY));
    }
}
