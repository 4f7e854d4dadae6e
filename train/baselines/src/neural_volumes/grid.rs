//! Cubes of values, and values between them.

use rayon::prelude::*;

use crate::network::Real;

/// Values that a thread adds at a time.
const PART: usize = 1 << 14;

/// Values at the points of a cube of [−1, 1]³: x fastest, then y, then z; all channels of a point
/// together.
#[derive(Clone, Debug)]
pub(super) struct Grid<T> {
    pub(super) side: usize,
    pub(super) channels: usize,
    pub(super) values: Vec<T>,
}

/// The eight points around a place, and where it lies among them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between<T> {
    first: usize,
    fraction: [T; 3],
    side: usize,
}

impl<T: Real> Grid<T> {
    pub(super) fn zeros(side: usize, channels: usize) -> Self {
        Self { side, channels, values: vec![T::zero(); side.pow(3) * channels] }
    }

    /// The same size, zero.
    pub(super) fn empty(&self) -> Self {
        Self::zeros(self.side, self.channels)
    }

    /// Where a place is; `None` outside the cube.
    #[inline]
    pub(super) fn find(&self, place: [T; 3]) -> Option<Between<T>> {
        let cells = self.side - 1;
        let (half, limit) = (T::of(0.5 * cells as f64), T::of(cells as f64));
        let (mut first, mut fraction) = (0, [T::zero(); 3]);
        for axis in [2, 1, 0] {
            let at = (place[axis] + T::one()) * half;
            // NaN is nowhere.
            if !(at >= T::zero() && at <= limit) {
                return None;
            }
            let cell = (at.value() as usize).min(cells - 1);
            first = first * self.side + cell;
            fraction[axis] = at - T::of(cell as f64);
        }
        Some(Between { first, fraction, side: self.side })
    }

    /// Values of so many channels from one on.
    #[inline]
    pub(super) fn values_at<const N: usize>(&self, between: &Between<T>, channel: usize) -> [T; N] {
        let mut sum = [T::zero(); N];
        let (points, weights) = (between.points(), between.weights());
        for corner in 0..8 {
            let values = &self.values[points[corner] * self.channels + channel..][..N];
            for c in 0..N {
                sum[c] += values[c] * weights[corner];
            }
        }
        sum
    }

    /// Adds to what values are made of: the way back of [`values_at`](Self::values_at).
    #[inline]
    pub(super) fn add<const N: usize>(&mut self, between: &Between<T>, channel: usize, d: [T; N]) {
        let (points, weights) = (between.points(), between.weights());
        for corner in 0..8 {
            let values = &mut self.values[points[corner] * self.channels + channel..][..N];
            for c in 0..N {
                values[c] += d[c] * weights[corner];
            }
        }
    }

    /// The gradient, with respect to the place, of the sum of channels times `d`.
    #[inline]
    pub(super) fn slope<const N: usize>(
        &self,
        between: &Between<T>,
        channel: usize,
        d: [T; N],
    ) -> [T; 3] {
        let mut along = [T::zero(); 8];
        let points = between.points();
        for corner in 0..8 {
            let values = &self.values[points[corner] * self.channels + channel..][..N];
            for c in 0..N {
                along[corner] += values[c] * d[c];
            }
        }
        let [x, y, z] = between.fraction;
        let mix = |a: T, b: T, t: T| a + (b - a) * t;
        // Differences along each axis, between the values along the two others.
        let along_x = mix(
            mix(along[1] - along[0], along[3] - along[2], y),
            mix(along[5] - along[4], along[7] - along[6], y),
            z,
        );
        let along_y = mix(
            mix(along[2] - along[0], along[3] - along[1], x),
            mix(along[6] - along[4], along[7] - along[5], x),
            z,
        );
        let along_z = mix(
            mix(along[4] - along[0], along[5] - along[1], x),
            mix(along[6] - along[2], along[7] - along[3], x),
            y,
        );
        let per_unit = T::of(0.5 * (self.side - 1) as f64);
        [along_x * per_unit, along_y * per_unit, along_z * per_unit]
    }

    /// Adds another grid of the same size.
    pub(super) fn add_grid(&mut self, other: &Self) {
        let parts = self.values.par_chunks_mut(PART).zip(other.values.par_chunks(PART));
        parts.for_each(|(sums, values)| {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += *value);
        });
    }
}

impl<T: Real> Between<T> {
    /// Numbers of the eight points.
    #[inline]
    fn points(&self) -> [usize; 8] {
        let (a, row, layer) = (self.first, self.side, self.side * self.side);
        let (b, c, d) = (a + row, a + layer, a + layer + row);
        [a, a + 1, b, b + 1, c, c + 1, d, d + 1]
    }

    /// Their weights.
    #[inline]
    fn weights(&self) -> [T; 8] {
        let [x, y, z] = self.fraction;
        let one = T::one();
        let [low, high] = [one - z, z];
        let [a, b, c, d] = [(one - y) * low, y * low, (one - y) * high, y * high];
        let left = one - x;
        [a * left, a * x, b * left, b * x, c * left, c * x, d * left, d * x]
    }
}
