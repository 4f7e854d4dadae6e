//! Elementary functions with a stated error, the same bits on every target.
//!
//! Scalar versions for set-up code. Only +, −, ×, ÷ and integer operations are
//! used (no fused multiply-add), so results do not depend on the platform.

/// Square root within 1 ulp; NaN for negative numbers, 0 for 0.
#[must_use]
pub fn sqrt(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 {
        return if x == 0.0 { 0.0 } else { f32::NAN };
    }
    if x.is_infinite() {
        return x;
    }
    // Newton in f64 from a bit-level guess; six steps reach f64 precision.
    let x = f64::from(x);
    let mut y = f64::from_bits((x.to_bits() >> 1) + (1023u64 << 51));
    for _ in 0..6 {
        y = 0.5 * (y + x / y);
    }
    y as f32
}

/// Sine and cosine of `x` radians, |error| ≤ 1e-7 for |x| ≤ 1e4.
#[must_use]
pub fn sin_cos(x: f32) -> (f32, f32) {
    const HALF_PI: f64 = core::f64::consts::FRAC_PI_2;
    let x = f64::from(x);
    let turns = x / HALF_PI;
    // Round to nearest quadrant; `as` saturates, so huge or NaN input ends somewhere finite.
    let quadrant = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i64;
    let r = x - quadrant as f64 * HALF_PI;
    let r2 = r * r;
    // Taylor on |r| ≤ π/4: the next terms are below 2e-11.
    let s = r
        * (1.0
            - r2 / 6.0
                * (1.0 - r2 / 20.0 * (1.0 - r2 / 42.0 * (1.0 - r2 / 72.0 * (1.0 - r2 / 110.0)))));
    let c = 1.0
        - r2 / 2.0 * (1.0 - r2 / 12.0 * (1.0 - r2 / 30.0 * (1.0 - r2 / 56.0 * (1.0 - r2 / 90.0))));
    let (s, c) = match quadrant & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    };
    (s as f32, c as f32)
}

/// Sine, see [`sin_cos`].
#[must_use]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// Cosine, see [`sin_cos`].
#[must_use]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// Tangent, see [`sin_cos`].
#[must_use]
pub fn tan(x: f32) -> f32 {
    let (s, c) = sin_cos(x);
    s / c
}

/// Natural exponential, relative error ≤ 1e-7; 0 below −87, cut off at e^88.
#[must_use]
pub fn exp(x: f32) -> f32 {
    if x.is_nan() {
        return x;
    }
    if x < -87.0 {
        return 0.0;
    }
    let x = f64::from(x.min(88.0));
    let n = (x * core::f64::consts::LOG2_E + if x < 0.0 { -0.5 } else { 0.5 }) as i64;
    let r = x - n as f64 * core::f64::consts::LN_2;
    let p = 1.0
        + r * (1.0
            + r / 2.0
                * (1.0
                    + r / 3.0
                        * (1.0 + r / 4.0 * (1.0 + r / 5.0 * (1.0 + r / 6.0 * (1.0 + r / 7.0))))));
    (p * f64::from_bits(((1023 + n) as u64) << 52)) as f32
}

/// Natural logarithm of a positive number, relative error ≤ 1e-6.
#[must_use]
pub fn ln(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 {
        return if x == 0.0 { f32::NEG_INFINITY } else { f32::NAN };
    }
    if x.is_infinite() {
        return x;
    }
    let bits = f64::from(x).to_bits();
    let mut e = ((bits >> 52) as i64) - 1023;
    let mut m = f64::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    if m > core::f64::consts::SQRT_2 {
        m *= 0.5;
        e += 1;
    }
    // ln m = 2 artanh((m - 1) / (m + 1)).
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut sum = 0.0;
    for k in (0..8).rev() {
        sum = sum * s2 + 1.0 / f64::from(2 * k + 1);
    }
    (2.0 * s * sum + e as f64 * core::f64::consts::LN_2) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn agrees_with_the_standard_library() {
        for i in -20_000..20_000 {
            let x = i as f32 * 0.004_37;
            let (s, c) = sin_cos(x);
            assert!((f64::from(s) - f64::from(x).sin()).abs() < 1e-7, "sin {x}");
            assert!((f64::from(c) - f64::from(x).cos()).abs() < 1e-7, "cos {x}");
            let e = f64::from(x).exp();
            assert!((f64::from(exp(x)) - e).abs() <= 1.2e-7 * e || x.abs() > 87.0, "exp {x}");
            if x > 0.0 {
                assert!((sqrt(x) - x.sqrt()).abs() <= x.sqrt() * 1.2e-7, "sqrt {x}");
                let l = f64::from(x).ln();
                assert!((f64::from(ln(x)) - l).abs() <= 1e-6 * l.abs().max(0.1), "ln {x}");
            }
        }
        assert_eq!(exp(-1000.0), 0.0);
        assert!(exp(1000.0).is_finite() && exp(f32::NAN).is_nan());
    }
}
