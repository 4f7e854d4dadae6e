//! Multiplications and additions in registers.

use std::hint::black_box;

use fearless_simd::{Simd, SimdBase, SimdFloat};

/// Sums that do not wait for each other: more than a core has in flight (ports
/// times latency), and few enough for 16 registers, or 32 on ARM.
const SUMS: usize = if cfg!(target_arch = "aarch64") { 24 } else { 12 };

const ROUNDS: usize = 1 << 13;

/// Floating-point operations of one call.
pub(super) const fn flops<S: Simd>() -> f64 {
    (2 * SUMS * ROUNDS * S::f32s::LEN) as f64
}

/// `sum * factor + 1`, over and over.
#[inline(always)]
pub(super) fn multiply_add<S: Simd>(simd: S) {
    simd.vectorize(
        #[inline(always)]
        || {
            let [factor, one] = [black_box(0.5), black_box(1.0)].map(|v| S::f32s::splat(simd, v));
            let mut sums = [one; SUMS];
            for _ in 0..ROUNDS {
                for sum in &mut sums {
                    *sum = sum.mul_add(factor, one);
                }
            }
            let mut all = one;
            for sum in sums {
                all += sum;
            }
            black_box(all.as_slice()[0]);
        },
    );
}
