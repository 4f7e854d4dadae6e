//! From rows of features to rows of samples and back.

use fearless_simd::{Simd, SimdBase};

/// Rows that are transposed at a time.
pub(super) const LANES: usize = 16;

/// Transposes the first `columns` (a multiple of 16) of 16 rows: value `(r, c)`
/// at `from[r * from_stride + c]` goes to `to[c * to_stride + r]`.
#[inline(always)]
pub(super) fn transpose<S: Simd>(
    simd: S,
    from: &[f32],
    from_stride: usize,
    to: &mut [f32],
    to_stride: usize,
    columns: usize,
) {
    let n = S::f32s::LEN;
    for column in (0..columns).step_by(n) {
        for row in (0..LANES).step_by(n) {
            let mut block = [S::f32s::splat(simd, 0.0); LANES];
            for (i, register) in block.iter_mut().enumerate().take(n) {
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
    use super::*;
    use fearless_simd::dispatch;
    use pocketnerf_core::SimdLevel;

    #[test]
    fn rows_become_columns() {
        let from: Vec<f32> = (0..16 * 40).map(|i| i as f32).collect();
        for level in SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            let mut to = vec![-1.0; 32 * 17];
            dispatch!(level, simd => transpose(simd, &from, 40, &mut to, 17, 32));
            for (r, c) in (0..16).flat_map(|r| (0..32).map(move |c| (r, c))) {
                assert_eq!(to[c * 17 + r], (r * 40 + c) as f32, "{level:?} {r} {c}");
            }
        }
    }
}
