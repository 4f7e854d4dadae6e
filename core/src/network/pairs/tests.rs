extern crate std;
use std::vec;
use std::vec::Vec;

use fearless_simd::Level;

use super::*;
use crate::{Layout, SimdLevel, TensorView};

/// The f16 equal to a number that has one, not subnormal.
fn f16(value: f32) -> [u8; 2] {
    let bits = value.to_bits();
    let sign = (bits >> 16) & 0x8000;
    let magnitude = match value.abs() {
        0.0 => 0,
        _ => ((bits & 0x7fff_ffff) - (112 << 23)) >> 13,
    };
    ((sign | magnitude) as u16).to_le_bytes()
}

/// A layer's weights, `[n_in][n_out]`, and biases.
struct Layer {
    n_in: usize,
    n_out: usize,
    weights: Vec<f32>,
    biases: Vec<f32>,
}

impl Layer {
    fn new(n_in: usize, n_out: usize, weight: impl Fn(usize) -> f32) -> Self {
        let biases = (0..n_out).map(|o| o as f32 / 8.0 - 1.0).collect();
        Self { n_in, n_out, weights: (0..n_in * n_out).map(weight).collect(), biases }
    }

    /// Its outputs, `[n_out][stride]`, at every level that has the instructions: the same bits.
    /// Rows of `x` are `stride` apart.
    fn outputs(&self, x: &[f32], n: usize, stride: usize, relu: bool) -> Vec<f32> {
        let bytes = |values: &[f32]| values.iter().flat_map(|v| f16(*v)).collect::<Vec<u8>>();
        let (weights, biases) = (bytes(&self.weights), bytes(&self.biases));
        let tensor = |bytes, rows: usize| {
            let shape = [rows as u32, self.n_out as u32];
            TensorView::new(bytes, DType::F16, shape, 0, Layout::RowMajor).unwrap()
        };
        let layer = Dense { weight: tensor(&weights, self.n_in), bias: Some(tensor(&biases, 1)) };
        assert!(suit(&layer));
        let mut found: Option<Vec<f32>> = None;
        let levels = [SimdLevel::Avx2, SimdLevel::Avx512].into_iter();
        for level in levels.filter_map(|level| level.token().ok()) {
            let (mut x, mut panel) = (x.to_vec(), vec![0.0; panel_len(self.n_in)]);
            let mut y = vec![0.0; self.n_out * stride];
            let mut run = |level: Level| match (level.as_avx512(), level.as_avx2()) {
                (Some(s), _) => dense(s, &layer, &mut x, &mut y, n, stride, relu, &mut panel),
                (_, Some(s)) => dense(s, &layer, &mut x, &mut y, n, stride, relu, &mut panel),
                _ => unreachable!(),
            };
            run(level);
            if let Some(found) = &found {
                let same = y.iter().zip(found).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "AVX2 and AVX-512 differ");
            }
            found = Some(y);
        }
        found.unwrap_or_default()
    }
}

/// Points of values between -1 and 1, `[n_in][stride]`.
fn points(n_in: usize, stride: usize) -> Vec<f32> {
    (0..n_in * stride).map(|i| ((i * 7919 + 13) % 1009) as f32 / 504.0 - 1.0).collect()
}

/// Beside sums in f64: as near as half a unit of every value and every weight allows.
#[test]
fn sums_are_near_exact_ones() {
    for (n_in, n_out, n, stride) in [
        (48, 64, 1024, 1040),
        (31, 21, 304, 368),
        (128, 3, 16, 16),
        (9, 8, 272, 272),
        (2, 9, 32, 32),
    ] {
        let layer = Layer::new(n_in, n_out, |i| ((i * 31 + 7) % 257) as f32 / 128.0 - 1.0);
        let x = points(n_in, stride);
        for relu in [false, true] {
            let found = layer.outputs(&x, n, stride, relu);
            if found.is_empty() {
                return;
            }
            for (o, s) in (0..n_out).flat_map(|o| (0..n).map(move |s| (o, s))) {
                let pairs = || {
                    let pair = |i: usize| (x[i * stride + s], layer.weights[i * n_out + o]);
                    (0..n_in).map(pair).map(|(x, w)| (f64::from(x), f64::from(w)))
                };
                let sum = |f: fn((f64, f64)) -> f64| pairs().map(f).sum::<f64>();
                let most = |f: fn((f64, f64)) -> f64| pairs().map(f).fold(0.0, f64::max);
                let (values, weights) = (sum(|(x, _)| x.abs()), sum(|(_, w)| w.abs()));
                let value_unit = most(|(x, _)| x.abs()) / f64::from(MOST);
                let weight_unit = most(|(_, w)| w.abs()) / f64::from(MOST_WEIGHT);
                let weight_unit = weight_unit.max(weights / f64::from(MOST_SUM));
                let bound = value_unit * weights + weight_unit * values;
                let bound = 0.51 * bound + 1e-5;
                let exact = pairs().map(|(x, w)| x * w).sum::<f64>() + f64::from(layer.biases[o]);
                let exact = if relu { exact.max(0.0) } else { exact };
                let found = f64::from(found[o * stride + s]);
                assert!((found - exact).abs() <= bound, "{found}, exact {exact} to {bound}");
            }
        }
    }
}

/// The largest sums that there are, of either sign, and none at all.
#[test]
fn sums_by_hand() {
    for n_in in [3, 128, 4096] {
        let (n, stride) = (16, 272);
        let layer = Layer::new(n_in, 8, |i| if i % 8 < 4 { 1.0 } else { -1.0 });
        let mut x = vec![2.0; n_in * stride];
        for row in x.chunks_mut(stride) {
            (row[1], row[2]) = (-2.0, 0.0);
        }
        let found = layer.outputs(&x, n, stride, false);
        for (o, row) in found.chunks(stride).enumerate() {
            let (bias, sum) = (layer.biases[o], if o < 4 { 2.0 } else { -2.0 } * n_in as f32);
            for (found, expected) in row.iter().zip([sum, -sum, 0.0]) {
                let error = (found - bias - expected).abs();
                let units = 1.0 / MOST + n_in as f32 / MOST_SUM;
                assert!(error <= 0.51 * units * sum.abs(), "{found}, by hand {}", expected + bias);
            }
            assert_eq!(row[2], bias);
        }
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    let (n, stride) = (32, 272);
    let layer = Layer::new(7, 9, |_| 0.5);
    for value in [f32::NAN, -f32::NAN, f32::INFINITY] {
        let mut x = points(7, stride);
        x[2 * stride + 5] = value;
        let found = layer.outputs(&x, n, stride, false);
        for (o, row) in found.chunks(stride).enumerate() {
            for (s, found) in row[..n].iter().enumerate() {
                assert_eq!(found.is_finite(), s != 5, "output {o} of point {s}: {found}");
            }
        }
    }
}
