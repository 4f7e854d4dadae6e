//! How spherical harmonics change with the direction.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

use pocketnerf_core::encoding::spherical_harmonics::{MAX_DEGREE, evaluate_each, n_output};

/// A value and its gradient: what is computed of it is computed with its gradient.
#[derive(Clone, Copy, Debug, Default)]
struct Dual([f32; 4]);

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(from_fn(|i| if i == 0 { a[0] * b[0] } else { a[0] * b[i] + a[i] * b[0] }))
    }
}

impl Mul<f32> for Dual {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|v| v * factor))
    }
}

/// From the gradient of a direction's harmonics to that of its coordinates.
pub(crate) fn gradient(
    degree: u32,
    [x, y, z]: [f32; 3],
    slopes: impl Iterator<Item = f32>,
) -> [f32; 3] {
    let mut harmonics = [Dual::default(); n_output(MAX_DEGREE)];
    let direction = [Dual([x, 1.0, 0.0, 0.0]), Dual([y, 0.0, 1.0, 0.0]), Dual([z, 0.0, 0.0, 1.0])];
    evaluate_each(degree, direction, Dual([1.0, 0.0, 0.0, 0.0]), &mut harmonics);
    let mut sum = [0.0; 3];
    for (Dual([_, gradient @ ..]), slope) in harmonics.iter().zip(slopes).take(n_output(degree)) {
        (0..3).for_each(|a| sum[a] += slope * gradient[a]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::encoding::spherical_harmonics::evaluate;

    use super::*;

    #[test]
    fn each_harmonic_against_differences() {
        let d = [0.48f32, -0.6, 0.64];
        for i in 0..n_output(MAX_DEGREE) {
            let found = gradient(MAX_DEGREE, d, (0..16).map(|k| if k == i { 1.0 } else { 0.0 }));
            for axis in 0..3 {
                let moved = |by: f32| {
                    let (mut d, mut harmonics) = (d, [0.0; 16]);
                    d[axis] += by;
                    evaluate(MAX_DEGREE, d, &mut harmonics);
                    harmonics[i]
                };
                let expected = (moved(0.01) - moved(-0.01)) / 0.02;
                assert!((found[axis] - expected).abs() < 1e-3, "{i}, {axis}: {found:?} {expected}");
            }
        }
    }
}
