//! Random reads of eight bytes: an entry of four features in half precision.

use std::hint::black_box;

use fearless_simd::{Simd, SimdBase};

/// Numbers that are drawn at a time.
const LANES: usize = 16;

const ROUNDS: u32 = 1 << 13;

/// Reads of one call.
pub(super) const READS: f64 = (LANES as u32 * ROUNDS) as f64;

/// Reads entries of `table`, whose length is a power of two. Places come from a
/// generator in registers (Numerical Recipes'), none from what was read before:
/// as many reads are under way as the core can hold.
#[inline(always)]
pub(super) fn read<S: Simd>(simd: S, table: &[u64], seed: u32) {
    simd.vectorize(
        #[inline(always)]
        || {
            let shift = 32 - table.len().trailing_zeros();
            let mut state = [0; LANES];
            for (lane, state) in (1..).zip(&mut state) {
                *state = (seed * LANES as u32 + lane).wrapping_mul(2_654_435_761);
            }
            let n = S::u32s::LEN;
            let mut places = [0; LANES];
            let mut sums = [0u64; 4];
            for _ in 0..ROUNDS {
                for first in (0..LANES).step_by(n) {
                    let lanes = &mut state[first..first + n];
                    let drawn = S::u32s::from_slice(simd, lanes) * 1_664_525 + 1_013_904_223;
                    drawn.store_slice(lanes);
                    // The low bits of such a generator hardly change.
                    (drawn >> shift).store_slice(&mut places[first..first + n]);
                }
                for (i, place) in places.iter().enumerate() {
                    let value = table[*place as usize & (table.len() - 1)];
                    sums[i % 4] = sums[i % 4].wrapping_add(value);
                }
            }
            black_box(sums);
        },
    );
}
