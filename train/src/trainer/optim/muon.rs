//! Muon (Jordan et al. 2024): steps of weight matrices that are as long in
//! every direction.
//!
//! Gradients of a small network have few large singular values, and Adam's
//! steps follow those. Here a step is the matrix with the singular vectors of
//! the mean gradient, and all singular values about 1.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, dispatch};
use rayon::prelude::*;

use crate::aligned::Aligned;
use crate::field::Layout;
use crate::field::rounding::Rounding;
use crate::trainer::optim::adam::{Adam, Slices, normal};

/// Steps that are taken this way. Longer runs end better with Adam, which goes
/// on from both moments: they are kept here as well.
pub(crate) const STEPS: u32 = 8000;
/// Decay of the mean gradient.
const MOMENTUM: f32 = 0.9;
/// Root mean square of a step, times the learning rate.
const STEP: f32 = 0.6;
/// Rounds that bring singular values from between about 0.003 and 1 to between
/// 0.7 and 1.2.
const ROUNDS: usize = 5;
/// A round's polynomial: `a x + b x^3 + c x^5` for every singular value x.
const ROUND: [f32; 3] = [3.4445, -4.775, 2.0315];
/// Of a norm below this, the square has lost its precision.
const FADED: f32 = 1e-15;
/// Of a matrix of norm 1, what is below this. Products of such numbers are subnormal, for which
/// a processor takes a hundred times as long; units that have died would fill whole rows with them.
const NOTHING: f32 = 1e-18;
/// Rows and columns that the kernel takes at a time.
const BLOCK: usize = 32;
/// Narrower matrices are left to Adam.
const NARROWEST: usize = 8;

/// One step of all networks: of their matrices at `rate`, of biases and narrow
/// matrices as Adam, at the rate beside it, would take it. `slices` begin where
/// the networks begin.
pub(crate) fn update_all<R: Rounding<Bits: Send> + Sync>(
    level: Level,
    rate: f32,
    layout: &Layout,
    (adam, adam_rate): (&Adam, f32),
    rounding: R,
    mut slices: Slices<'_, R::Bits>,
) {
    let mut tasks = Vec::with_capacity(layout.networks().len());
    for range in layout.networks() {
        tasks.push((range.shape, slices.split_off(range.len())));
    }
    tasks.into_par_iter().with_max_len(1).for_each(|(shape, slices)| {
        dispatch!(level, simd => update_one(simd, rate, shape, (adam, adam_rate), rounding, slices));
    });
}

#[inline(always)]
fn update_one<S: Simd, R: Rounding>(
    simd: S,
    rate: f32,
    shape: [usize; 2],
    (adam, adam_rate): (&Adam, f32),
    rounding: R,
    slices: Slices<'_, R::Bits>,
) {
    if shape.into_iter().min() >= Some(NARROWEST) {
        for (square, g) in slices.square.iter_mut().zip(slices.gradient.iter()) {
            *square += (g * g - *square) * (1.0 - adam.beta2);
        }
        update(simd, rate, shape, rounding, slices);
    } else {
        adam.update(simd, adam_rate, rounding, slices);
    }
}

/// One step of a matrix of `shape`, row after row.
#[inline(always)]
fn update<S: Simd, R: Rounding>(
    simd: S,
    rate: f32,
    shape: [usize; 2],
    rounding: R,
    slices: Slices<'_, R::Bits>,
) {
    let Slices { parameters, gradient, mean, rounded, .. } = slices;
    let mut direction = Matrix::new(shape);
    for (i, (mean, gradient)) in mean.iter_mut().zip(gradient).enumerate() {
        *mean = normal(*mean + (*gradient - *mean) * (1.0 - MOMENTUM));
        // As if the step had been taken already (Nesterov).
        *direction.at(i) = *mean + (*gradient - *mean) * (1.0 - MOMENTUM);
        *gradient = 0.0;
    }
    simd.vectorize(
        #[inline(always)]
        || direction.orthogonalize(simd),
    );
    // An orthogonal matrix's elements have the mean square 1 / its longer side.
    let longer = shape[0].max(shape[1]) as f32;
    let length = rate * STEP * longer.sqrt();
    for (i, parameter) in parameters.iter_mut().enumerate() {
        *parameter -= length * *direction.at(i);
    }
    rounding.round_all(simd, parameters, rounded);
}

/// A matrix that is at least as wide as it is high, filled up with zeros to
/// whole blocks.
struct Matrix {
    /// Of the matrix that it holds, perhaps turned on its side.
    shape: [usize; 2],
    rows: usize,
    columns: usize,
    values: Aligned<f32>,
}

impl Matrix {
    fn new(shape: [usize; 2]) -> Self {
        let rows = shape[0].min(shape[1]).next_multiple_of(BLOCK);
        let columns = shape[0].max(shape[1]).next_multiple_of(BLOCK);
        Self { shape, rows, columns, values: Aligned::new(rows * columns) }
    }

    /// Value `i` of the matrix that it holds.
    #[inline(always)]
    fn at(&mut self, i: usize) -> &mut f32 {
        let (row, column) = (i / self.shape[1], i % self.shape[1]);
        let (row, column) =
            if self.shape[0] <= self.shape[1] { (row, column) } else { (column, row) };
        &mut self.values[row * self.columns + column]
    }

    /// Brings all singular values near 1 (Newton and Schulz's iteration with a
    /// polynomial that rises steeply at 0). A mean gradient that has all but faded
    /// away says nothing any more: zero. NaN spreads, for the guard to see.
    #[inline(always)]
    fn orthogonalize<S: Simd>(&mut self, simd: S) {
        let Self { rows, columns, values, .. } = self;
        let (rows, columns) = (*rows, *columns);
        let norm = values.iter().map(|v| v * v).sum::<f32>().sqrt();
        if norm < FADED {
            values.fill(0.0);
            return;
        }
        // No singular value is larger than the norm.
        for value in values.iter_mut() {
            *value /= norm;
            *value = if value.abs() < NOTHING { 0.0 } else { *value };
        }
        let [a, b, c] = ROUND;
        let mut turned = Aligned::new(rows * columns);
        let [mut square, mut fourth] = [Aligned::new(rows * rows), Aligned::new(rows * rows)];
        let mut product = Aligned::new(rows * columns);
        for _ in 0..ROUNDS {
            for (r, row) in values.chunks_exact(columns).enumerate() {
                for (column, value) in row.iter().enumerate() {
                    turned[column * rows + r] = *value;
                }
            }
            multiply(simd, values, &turned, &mut square, [rows, columns, rows]);
            multiply(simd, &square, &square, &mut fourth, [rows; 3]);
            for (fourth, square) in fourth.iter_mut().zip(square.iter()) {
                *fourth = b * square + c * *fourth;
            }
            multiply(simd, &fourth, values, &mut product, [rows, rows, columns]);
            for (value, product) in values.iter_mut().zip(product.iter()) {
                *value = a * *value + product;
            }
        }
    }
}

/// `product = a b`, `[m, k]` times `[k, n]`; all whole blocks.
#[inline(always)]
fn multiply<S: Simd>(simd: S, a: &[f32], b: &[f32], product: &mut [f32], [m, k, n]: [usize; 3]) {
    const ROWS: usize = 4;
    let lanes = S::f32s::LEN;
    let zero = S::f32s::splat(simd, 0.0);
    for i in (0..m).step_by(ROWS) {
        for j in (0..n).step_by(2 * lanes) {
            let mut sums = [[zero; 2]; ROWS];
            for (l, row) in b.chunks_exact(n).enumerate() {
                let values = [j, j + lanes].map(|j| S::f32s::from_slice(simd, &row[j..j + lanes]));
                for (r, sums) in sums.iter_mut().enumerate() {
                    let factor = S::f32s::splat(simd, a[(i + r) * k + l]);
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum = value.mul_add(factor, *sum);
                    }
                }
            }
            for (r, sums) in sums.iter().enumerate() {
                for (v, sum) in sums.iter().enumerate() {
                    sum.store_slice(&mut product[(i + r) * n + j + v * lanes..][..lanes]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::field::rounding::Half;
    use crate::random::Random;

    fn random(n: usize) -> Vec<f32> {
        let mut random = Random::new(7, [0; 3]);
        (0..n).map(|_| random.next_f32() - 0.5).collect()
    }

    #[test]
    fn products_by_hand() {
        let (a, b) = (random(32 * 64), random(64 * 32));
        for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
            let mut product = vec![0.0; 32 * 32];
            dispatch!(level, simd => multiply(simd, &a, &b, &mut product, [32, 64, 32]));
            for (i, j) in (0..32).flat_map(|i| (0..32).map(move |j| (i, j))) {
                let sum: f32 = (0..64).map(|l| a[i * 64 + l] * b[l * 32 + j]).sum();
                assert!((product[i * 32 + j] - sum).abs() < 1e-4, "{level:?} {i} {j}");
            }
        }
    }

    /// What a step makes of a matrix of zeros.
    fn step_of(shape: [usize; 2], gradient: &[f32]) -> Vec<f32> {
        let level = SimdLevel::detect().token().unwrap();
        let n = shape[0] * shape[1];
        let (mut parameters, mut gradient) = (vec![0.0; n], gradient.to_vec());
        let (mut mean, mut rounded) = (vec![0.0; n], vec![0; n]);
        dispatch!(level, simd => update(simd, 1.0, shape, Half, Slices {
            parameters: &mut parameters,
            gradient: &mut gradient,
            mean: &mut mean,
            square: &mut [],
            rounded: &mut rounded,
        }));
        assert!(gradient.iter().all(|g| *g == 0.0));
        parameters
    }

    #[test]
    fn a_step_is_as_long_in_every_direction() {
        // Diagonal gradients of very different sizes give steps of about one size,
        // downhill, whichever side is longer.
        for shape in [[10, 36], [36, 10]] {
            let mut gradient = vec![0.0; 360];
            for i in 0..10 {
                gradient[i * shape[1] + i] = if i % 2 == 0 { 1.0 } else { -0.02 };
            }
            let step = step_of(shape, &gradient);
            for (i, step) in step.iter().enumerate() {
                let (row, column) = (i / shape[1], i % shape[1]);
                let length = step / (STEP * 6.0);
                match (row == column, row % 2) {
                    (true, 0) => assert!((-1.3..-0.6).contains(&length), "{i}: {length}"),
                    (true, _) => assert!((0.6..1.3).contains(&length), "{i}: {length}"),
                    (false, _) => assert!(length.abs() < 1e-6, "{i}: {length}"),
                }
            }
        }
    }

    #[test]
    fn the_same_step_at_any_scale_and_no_silent_nan() {
        let gradient = random(16 * 40);
        let larger: Vec<f32> = gradient.iter().map(|g| g * 1024.0).collect();
        assert_eq!(step_of([16, 40], &gradient), step_of([16, 40], &larger));
        assert!(step_of([16, 40], &[0.0; 640]).iter().all(|p| *p == 0.0));
        let faded: Vec<f32> = gradient.iter().map(|g| g * 1e-24).collect();
        assert!(step_of([16, 40], &faded).iter().all(|p| *p == 0.0));
        assert!(step_of([16, 40], &[f32::NAN; 640]).iter().all(|p| p.is_nan()));
    }
}
