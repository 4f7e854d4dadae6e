//! Planes and lines with more entries that say the same: interpolated.

use pocketnerf_core::encoding::planes::FEATURES;

/// A plane of `from²` entries, in a plane of `to²`.
pub(super) fn plane(values: &[f32], from: usize, to: usize) -> Vec<f32> {
    let rows = values.chunks_exact(from * FEATURES).map(|row| line(row, from, to));
    along(&rows.collect::<Vec<_>>(), to)
}

/// A line of `from` entries, in a line of `to`.
pub(super) fn line(values: &[f32], from: usize, to: usize) -> Vec<f32> {
    along(&values.chunks_exact(FEATURES).take(from).map(<[f32]>::to_vec).collect::<Vec<_>>(), to)
}

/// So many rows where there are fewer, the first and the last as they are.
fn along(rows: &[Vec<f32>], to: usize) -> Vec<f32> {
    let ratio = (rows.len() - 1) as f64 / (to - 1) as f64;
    let at = |i: usize| {
        let position = i as f64 * ratio;
        let low = (position as usize).min(rows.len() - 2);
        let share = (position - low as f64) as f32;
        let between = move |(a, b): (&f32, &f32)| a + (b - a) * share;
        rows[low].iter().zip(&rows[low + 1]).map(between)
    };
    (0..to).flat_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_linear_stays_as_it_is() {
        let value = |x: f32, y: f32, v: usize| 3.0 * x - 2.0 * y + v as f32 * x * y;
        let entries = |n: usize| {
            let at = move |i: usize| i as f32 / (n - 1) as f32;
            (0..n * n).flat_map(move |e| (0..FEATURES).map(move |v| value(at(e % n), at(e / n), v)))
        };
        let [from, expected] = [5, 12].map(|n| entries(n).collect::<Vec<_>>());
        let found = plane(&from, 5, 12);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert_eq!(line(&from[..2 * FEATURES], 2, 3)[..FEATURES], from[..FEATURES]);
    }
}
