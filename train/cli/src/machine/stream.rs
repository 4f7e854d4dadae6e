//! Reading memory sequentially.

use std::hint::black_box;

use fearless_simd::{Simd, SimdBase};

/// Registers that are summed up side by side.
const SUMS: usize = 8;

/// Adds up all of `values`, whose length is a multiple of 128.
#[inline(always)]
pub(super) fn sum<S: Simd>(simd: S, values: &[f32]) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut sums = [S::f32s::splat(simd, 0.0); SUMS];
            for part in values.chunks_exact(SUMS * S::f32s::LEN) {
                for (sum, lanes) in sums.iter_mut().zip(part.chunks_exact(S::f32s::LEN)) {
                    *sum += S::f32s::from_slice(simd, lanes);
                }
            }
            let mut all = sums[0];
            for sum in &sums[1..] {
                all += *sum;
            }
            black_box(all.as_slice()[0]);
        },
    );
}
