//! Rates that depend on how much memory is read.

use serde::Serialize;

use super::rate::Rate;

/// Rates of reading from buffers of several sizes, in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(pub Vec<Point>);

/// The rate of reading from a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Size of the buffer.
    pub bytes: usize,
    /// Bytes or reads per second.
    pub rate: Rate,
}

impl Curve {
    /// The better of two measurements of the same buffers.
    pub(super) fn best(mut self, other: &Self) -> Self {
        for (point, other) in self.0.iter_mut().zip(&other.0) {
            point.rate = point.rate.best(other.rate);
        }
        self
    }

    /// The rate of a buffer of this size: interpolated linearly over the logarithm of the
    /// size, and beyond the measured sizes that of the nearest.
    #[must_use]
    pub fn at(&self, bytes: f64) -> Rate {
        let [first, .., last] = &self.0[..] else {
            return self.0[0].rate;
        };
        if bytes <= first.bytes as f64 {
            return first.rate;
        }
        for pair in self.0.windows(2) {
            let [low, high] = [pair[0].bytes as f64, pair[1].bytes as f64];
            if bytes <= high {
                let part = (bytes / low).ln() / (high / low).ln();
                let mix = |a: f64, b: f64| a + (b - a) * part;
                return Rate {
                    one_thread: mix(pair[0].rate.one_thread, pair[1].rate.one_thread),
                    all: mix(pair[0].rate.all, pair[1].rate.all),
                };
            }
        }
        last.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_and_beyond_what_was_measured() {
        let point =
            |bytes, rate: f64| Point { bytes, rate: Rate { one_thread: rate, all: 2.0 * rate } };
        let curve = Curve(vec![point(1 << 10, 8.0), point(1 << 12, 4.0), point(1 << 20, 1.0)]);
        let at = |bytes: f64| curve.at(bytes).one_thread;
        assert_eq!((at(1.0), at(1024.0), at(4096.0), at(1e9)), (8.0, 8.0, 4.0, 1.0));
        assert!((at(2048.0) - 6.0).abs() < 1e-12);
        assert!((curve.at(2048.0).all - 12.0).abs() < 1e-12);
        let other = Curve(vec![point(1 << 10, 2.0), point(1 << 12, 6.0), point(1 << 20, 1.0)]);
        let best: Vec<f64> = curve.best(&other).0.iter().map(|p| p.rate.one_thread).collect();
        assert_eq!(best, [8.0, 6.0, 1.0]);
    }
}
