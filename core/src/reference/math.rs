//! Elementary functions in f64 as plain series. `core` has none of its own, and
//! the oracle does not borrow those of [`crate::math`], which it checks.

use core::f64::consts::{LOG2_E, PI};

/// e^x, relative error ≤ 1e-15. 0 below −708, infinite above 709, NaN for NaN.
pub(crate) fn exp(x: f64) -> f64 {
    /// ln 2 to 32 bits, so that whole multiples of it are exact, and the rest.
    const LN_2: [f64; 2] =
        [f64::from_bits(0x3fe6_2e42_fee0_0000), f64::from_bits(0x3dea_39ef_3579_3c76)];
    if x.is_nan() {
        return x;
    }
    if x < -708.0 {
        return 0.0;
    }
    if x > 709.0 {
        return f64::INFINITY;
    }
    // e^x = 2^n e^r with |r| ≤ ln 2 / 2.
    let n = nearest(x * LOG2_E);
    let r = x - n as f64 * LN_2[0] - n as f64 * LN_2[1];
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..=16 {
        term *= r / f64::from(k);
        sum += term;
    }
    sum * f64::from_bits(((1023 + n) as u64) << 52)
}

/// Sine and cosine of π x, error ≤ 1e-15 for |x| ≤ 2^50: whole half turns are
/// taken off before π comes in, without rounding.
#[cfg_attr(not(feature = "nerf"), allow(dead_code, reason = "only waves need it"))]
pub(crate) fn sin_cos_pi(x: f64) -> (f64, f64) {
    let quarter = nearest(2.0 * x);
    let r = PI * (x - 0.5 * quarter as f64);
    // Taylor on |r| ≤ π / 4: the terms left out are below 1e-20.
    let (mut sin, mut cos, mut term) = (0.0, 0.0, 1.0);
    for k in 0..20 {
        match k % 4 {
            0 => cos += term,
            1 => sin += term,
            2 => cos -= term,
            _ => sin -= term,
        }
        term *= r / f64::from(k + 1);
    }
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Square root of a normal positive number, relative error ≤ 1e-15.
pub(super) fn sqrt(x: f64) -> f64 {
    // Newton, from a guess with half the exponent.
    let mut y = f64::from_bits((x.to_bits() >> 1) + (1023 << 51));
    for _ in 0..6 {
        y = 0.5 * (y + x / y);
    }
    y
}

/// 1 / (1 + e^−x). NaN becomes 0: no picture holds NaN, whatever the weights.
pub(crate) fn logistic(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { 1.0 / (1.0 + exp(-x)) }
}

fn nearest(x: f64) -> i64 {
    (x + if x < 0.0 { -0.5 } else { 0.5 }) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn agrees_with_the_standard_library() {
        for i in -70_000..70_000 {
            let x = f64::from(i) * 0.010_013;
            let e = x.exp();
            assert!((exp(x) - e).abs() <= 1e-15 * e, "exp {x}");
            let (s, c) = sin_cos_pi(x);
            let half_turns = x.rem_euclid(2.0);
            assert!((s - (PI * half_turns).sin()).abs() < 2e-15, "sin {x}");
            assert!((c - (PI * half_turns).cos()).abs() < 2e-15, "cos {x}");
            if x > 0.0 {
                assert!((sqrt(x) - x.sqrt()).abs() <= 1e-15 * x.sqrt(), "sqrt {x}");
            }
        }
    }

    #[test]
    fn ends_of_the_range() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1e300), 0.0);
        assert_eq!(exp(1e300), f64::INFINITY);
        assert!(exp(f64::NAN).is_nan());
        assert_eq!(logistic(0.0), 0.5);
        assert_eq!((logistic(-1e9), logistic(1e9), logistic(f64::NAN)), (0.0, 1.0, 0.0));
        assert_eq!(sin_cos_pi(0.5), (1.0, 0.0));
        // An odd number of half turns, far out: exactly (0, -1).
        assert_eq!(sin_cos_pi(32_767.0), (0.0, -1.0));
    }
}
