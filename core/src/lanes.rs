//! Elementary functions in SIMD lanes.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat};

/// Values that kernels take at a time: the lanes of the widest registers. Narrower ones
/// take them in parts.
pub const LANES: usize = 16;

/// e^x, relative error ≤ 4e-7; 0 below −87 and for NaN, cut off at e^88.
#[inline(always)]
pub fn exp<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |v: f32| S::f32s::splat(simd, v);
    let clamped = x.max_precise(-87.0).min_precise(88.0);
    let n = (clamped * core::f32::consts::LOG2_E).round_ties_even();
    // Cody and Waite: ln 2 in two parts, so that n ln 2 loses nothing.
    let r = n.mul_add(splat(-0.693_359_4), clamped);
    let r = n.mul_add(splat(2.121_944_4e-4), r);
    let mut p = splat(1.0 / 720.0);
    for c in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        p = p.mul_add(r, splat(c));
    }
    let exponent: S::f32s = ((n.to_int::<S::i32s>() + 127) << 23).bitcast();
    let value = p * exponent;
    x.simd_ge(splat(-87.0)).select(value, splat(0.0))
}

/// 1 / (1 + e^−x), absolute error ≤ 3e-7. NaN gives 0.
#[inline(always)]
pub fn logistic<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let e = exp(simd, x);
    e / (e + 1.0)
}

/// `ln(1 + e^x)`, relative error ≤ 1e-6 or absolute error ≤ 1e-7. NaN gives 0.
#[inline(always)]
pub fn softplus<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |v: f32| S::f32s::splat(simd, v);
    // ln(1 + e^x) = max(x, 0) + ln(1 + e^-|x|), and with y = e^-|x| / (2 + e^-|x|), at
    // most 1/3, ln(1 + e^-|x|) = 2 artanh y.
    let e = exp(simd, -x.abs());
    let y = e / (e + 2.0);
    let y2 = y * y;
    let mut p = splat(1.0 / 13.0);
    for c in [1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0] {
        p = p.mul_add(y2, splat(c));
    }
    x.max_precise(splat(0.0)) + y * p * 2.0
}

/// `sin(π x)`, absolute error ≤ 3e-7 for |x| < 2^22; the range reduction is exact.
#[inline(always)]
pub fn sin_pi<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |v: f32| S::f32s::splat(simd, v);
    let n = x.round_ties_even();
    let r = x - n;
    let r2 = r * r;
    // Taylor series of sin(π r) / r on |r| ≤ 1/2; the next term is below 4e-8.
    let mut p = splat(-0.007_370_43);
    for c in [0.082_145_89, -0.599_264_5, 2.550_164, -5.167_712_8, core::f32::consts::PI] {
        p = p.mul_add(r2, splat(c));
    }
    let odd: S::f32s = (n.to_int::<S::i32s>() << 31).bitcast();
    let value: S::i32s = (p * r).bitcast();
    (value ^ odd.bitcast::<S::i32s>()).bitcast()
}

/// Transposes the first `columns` (a multiple of 16) of 16 rows: value `(r, c)`
/// at `from[r * from_stride + c]` goes to `to[c * to_stride + r]`. Rows from
/// `rows` on are not there and count as 0.
#[inline(always)]
pub fn transpose<S: Simd>(
    simd: S,
    (from, from_stride, rows): (&[f32], usize, usize),
    (to, to_stride): (&mut [f32], usize),
    columns: usize,
) {
    let n = S::f32s::LEN;
    for column in (0..columns).step_by(n) {
        for row in (0..LANES).step_by(n) {
            let mut block = [S::f32s::splat(simd, 0.0); LANES];
            let there = rows.saturating_sub(row).min(n);
            for (i, register) in block.iter_mut().enumerate().take(there) {
                *register =
                    S::f32s::from_slice(simd, &from[(row + i) * from_stride + column..][..n]);
            }
            // Each round shuffles the two halves together, like cards: after
            // log2(n) rounds rows have become columns.
            let mut rounds = 1;
            while rounds < n {
                let before = block;
                for i in 0..n / 2 {
                    (block[2 * i], block[2 * i + 1]) = before[i].interleave(before[i + n / 2]);
                }
                rounds *= 2;
            }
            for (i, register) in block.iter().enumerate().take(n) {
                register.store_slice(&mut to[(column + i) * to_stride + row..][..n]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use fearless_simd::dispatch;
    use std::vec::Vec;

    #[test]
    fn rows_become_columns() {
        let from: Vec<f32> = (0..16 * 40).map(|i| i as f32).collect();
        for level in crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            for rows in [16, 11, 3] {
                let mut to = [-1.0; 32 * 17];
                let (from, to) = ((&from[..rows * 40], 40, rows), &mut to);
                dispatch!(level, simd => transpose(simd, from, (to, 17), 32));
                for (r, c) in (0..16).flat_map(|r| (0..32).map(move |c| (r, c))) {
                    let expected = if r < rows { (r * 40 + c) as f32 } else { 0.0 };
                    assert_eq!(to[c * 17 + r], expected, "{level:?} {r} {c}");
                }
            }
        }
    }

    #[test]
    fn within_the_stated_error_at_every_level() {
        for level in crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            dispatch!(level, simd => check(simd));
        }
    }

    fn check<S: Simd>(simd: S) {
        let at = |f: &dyn Fn(S::f32s) -> S::f32s, x: f32| {
            f64::from(f(S::f32s::splat(simd, x)).as_slice()[0])
        };
        for i in -17_400..17_400 {
            let x = i as f32 * 0.005;
            let e = f64::from(x).exp();
            assert!((at(&|v| exp(simd, v), x) - e).abs() <= 4e-7 * e, "exp {x}");
            let l = 1.0 / (1.0 + (-f64::from(x)).exp());
            assert!((at(&|v| logistic(simd, v), x) - l).abs() <= 3e-7, "logistic {x}");
            {
                let p = f64::from(x).exp().ln_1p();
                assert!((at(&|v| softplus(simd, v), x) - p).abs() <= 1e-7 + 1e-6 * p, "{x}");
            }
            let s = (f64::from(x) % 2.0 * core::f64::consts::PI).sin();
            assert!((at(&|v| sin_pi(simd, v), x) - s).abs() <= 3e-7, "sin_pi {x}");
        }
        assert_eq!(at(&|v| exp(simd, v), -1e30), 0.0);
        assert!(at(&|v| exp(simd, v), 1e30) > 1e38);
        assert_eq!(at(&|v| exp(simd, v), f32::NAN), 0.0);
        for (x, limit) in [(-1e30, 0.0), (1e30, 1.0), (f32::NAN, 0.0)] {
            assert_eq!(at(&|v| logistic(simd, v), x), limit, "logistic {x}");
        }
    }
}
