//! Encodings in f64, one entry at a time.

use pocketnerf_core::encoding::HashGridConfig;
use pocketnerf_core::encoding::hash_grid::{HASH_PRIMES, Level as GridLevel};

use super::Encoding;
use crate::field::{Layout, PlanesConfig};

/// An encoding as a function of its parameters.
pub(super) trait Exact: Encoding {
    /// The entries that a point reads, and how.
    type Places;

    /// Those of unit point `u`.
    fn places(&self, u: [f64; 3]) -> Self::Places;

    /// The values of an encoded point.
    fn encoded(&self, layout: &Layout, parameters: &[f64], places: &Self::Places) -> Vec<f64>;
}

impl Exact for HashGridConfig {
    /// Eight entries and their weights a level.
    type Places = Vec<[(usize, f64); 8]>;

    fn places(&self, u: [f64; 3]) -> Self::Places {
        (0..self.n_levels as usize).map(|l| corners(&self.level(l), u)).collect()
    }

    fn encoded(&self, layout: &Layout, parameters: &[f64], places: &Self::Places) -> Vec<f64> {
        let mut values = Vec::new();
        for (corners, range) in places.iter().zip(layout.tables()) {
            let [_, n_features] = range.shape;
            values.extend((0..n_features).map(|f| {
                let value = |(entry, w)| w * parameters[range.start + entry * n_features + f];
                corners.iter().copied().map(value).sum::<f64>()
            }));
        }
        values
    }
}

impl Exact for PlanesConfig {
    /// Positions along the lines.
    type Places = [f64; 3];

    fn places(&self, u: [f64; 3]) -> [f64; 3] {
        u.map(|u| u * f64::from(self.resolution - 1))
    }

    fn encoded(&self, layout: &Layout, parameters: &[f64], places: &[f64; 3]) -> Vec<f64> {
        let [x, y, z] = *places;
        let n = self.resolution as usize;
        let mut values = Vec::new();
        let pairs = layout.tables().as_chunks::<2>().0;
        for (number, [plane, line]) in pairs.iter().enumerate() {
            let [along, first, second] =
                [[x, y, z], [y, x, z], [z, x, y]][number * 3 / pairs.len()];
            values.extend((0..plane.shape[1]).map(|f| {
                let value = |start: usize, e: usize| parameters[start + e * plane.shape[1] + f];
                let row = |r: usize| between(first, |i| value(plane.start, i + n * r));
                between(second, row) * between(along, |i| value(line.start, i))
            }));
        }
        values
    }
}

/// The value at a position, from those of the entries around it.
fn between(position: f64, value: impl Fn(usize) -> f64) -> f64 {
    let share = position.fract();
    value(position as usize) * (1.0 - share) + value(position as usize + 1) * share
}

/// The corners of a point's cell, numbered in blocks of 2×2×2.
fn corners(level: &GridLevel, u: [f64; 3]) -> [(usize, f64); 8] {
    let position = u.map(|u| u * f64::from(level.scale) + 0.5);
    std::array::from_fn(|c| {
        let high = [0, 1, 2].map(|axis| c >> axis & 1);
        let corner = [0, 1, 2].map(|axis| position[axis] as u32 + high[axis] as u32);
        let weight: f64 = (0..3)
            .map(|axis| position[axis].fract())
            .zip(high)
            .map(|(fraction, high)| if high == 1 { fraction } else { 1.0 - fraction })
            .product();
        let [x, y, z] = corner.map(|c| c >> 1);
        let block = match level.dense_side {
            0 => {
                let [a, b, c] = HASH_PRIMES;
                let hash = x.wrapping_mul(a) ^ y.wrapping_mul(b) ^ z.wrapping_mul(c);
                hash % (level.entries / 8)
            }
            n => x + n * (y + n * z),
        };
        let low = corner.map(|c| c & 1);
        ((8 * block + low[0] + 2 * low[1] + 4 * low[2]) as usize, weight)
    })
}
