//! Spherical harmonics from their definition, rather than from a table of
//! polynomials.

use core::f64::consts::PI;

use super::math::sqrt;
use crate::encoding::spherical_harmonics::MAX_DEGREE;

/// Values of the highest degree.
pub(super) const MAX_HARMONICS: usize = (MAX_DEGREE * MAX_DEGREE) as usize;

/// The first `degree²` real harmonics of the unit vector `d`; the rest are 0.
///
/// Value `l² + l + m` is the harmonic of band l and order m, −l ≤ m ≤ l, with the
/// Condon–Shortley phase (−1)^m:
/// `K (−1)^m D(l, |m|)(z) × { Re (x + iy)^m, m ≥ 0; Im (x + iy)^|m|, m < 0 }`,
/// where `D(l, m)` is the m-th derivative of the Legendre polynomial of degree l
/// and `K = sqrt((2 − [m = 0]) (2l + 1) / 4π × (l − |m|)! / (l + |m|)!)`.
pub(crate) fn harmonics(degree: u32, d: [f32; 3]) -> [f64; MAX_HARMONICS] {
    let [x, y, z] = d.map(f64::from);
    let mut out = [0.0; MAX_HARMONICS];
    let (mut re, mut im, mut sign) = (1.0, 0.0, 1.0);
    for m in 0..degree {
        for l in m..degree {
            let k = sqrt(
                if m == 0 { 1.0 } else { 2.0 } * f64::from(2 * l + 1) / (4.0 * PI)
                    * factorial(l - m)
                    / factorial(l + m),
            );
            let shared = k * sign * legendre_derivative(l, m, z);
            let middle = (l * l + l) as usize;
            out[middle - m as usize] = shared * im;
            out[middle + m as usize] = shared * re;
        }
        (re, im) = (re * x - im * y, re * y + im * x);
        sign = -sign;
    }
    out
}

/// The m-th derivative of the Legendre polynomial of degree l at z, m ≤ l, by
/// `(l − m) D(l, m) = (2l − 1) z D(l − 1, m) − (l + m − 1) D(l − 2, m)`.
fn legendre_derivative(l: u32, m: u32, z: f64) -> f64 {
    // D(m, m) = 1 · 3 · 5 … (2m − 1), D(m − 1, m) = 0.
    let (mut below, mut here) = (0.0, 1.0);
    for k in 0..m {
        here *= f64::from(2 * k + 1);
    }
    for n in m + 1..=l {
        let next =
            (f64::from(2 * n - 1) * z * here - f64::from(n + m - 1) * below) / f64::from(n - m);
        (below, here) = (here, next);
    }
    here
}

fn factorial(n: u32) -> f64 {
    (1..=n).map(f64::from).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::spherical_harmonics;

    #[test]
    fn legendre_polynomials_by_hand() {
        // P3 = (5z³ − 3z) / 2, P3' = (15z² − 3) / 2, P3'' = 15z, P3''' = 15.
        for (m, hand) in [-0.4375, 0.375, 7.5, 15.0].into_iter().enumerate() {
            assert_eq!(legendre_derivative(3, m as u32, 0.5), hand);
        }
    }

    #[test]
    fn along_an_axis_by_hand() {
        // Along y, P1's derivative is 1: −sqrt(3 / 4π) stands at l = 1, m = −1.
        let out = harmonics(2, [0.0, 1.0, 0.0]);
        assert!((out[0] - 0.282_094_791_773_878_1).abs() < 1e-15);
        assert!((out[1] + 0.488_602_511_902_919_9).abs() < 1e-15);
        assert_eq!(out[2..], [0.0; 14]);
    }

    #[test]
    fn the_basis_of_the_encoding() {
        for i in 0..1000u32 {
            let turn = i as f32 * 0.61;
            let z = 0.999 - 1.998 * i as f32 / 999.0;
            let r = crate::math::sqrt(1.0 - z * z);
            let d = [r * crate::math::cos(turn), r * crate::math::sin(turn), z];
            for degree in 1..=MAX_DEGREE {
                let mut fast = [0.0f32; MAX_HARMONICS];
                spherical_harmonics::evaluate(degree, d, &mut fast);
                for (slow, fast) in harmonics(degree, d).into_iter().zip(fast) {
                    assert!((slow - f64::from(fast)).abs() < 1e-6, "{degree} {d:?}");
                }
            }
        }
    }
}
