//! The parameters in half precision, as the model file will hold them.
//!
//! The forward pass of training reads these: what is learnt is learnt for the
//! rounded values, and the tables take half of the cache. The optimizer
//! keeps the parameters themselves in `f32`.

use fearless_simd::{Bytes, Select, Simd, SimdBase};

/// Exponent of the unit of the stored values. Grids start near 1e-4, and
/// nothing that is learnt comes near 255.
pub const SCALE_LOG2: i8 = -8;

/// f16's largest number.
const MAX: f32 = 65504.0;
/// 2^(8 − 112): the unit and the difference of f32's and f16's exponent biases.
const SCALE: f32 = f32::from_bits(((127 - 112 - SCALE_LOG2 as i32) as u32) << 23);
/// 2^−112.
const REBIAS: f32 = f32::from_bits((127 - 112) << 23);

/// Rounds a register of parameters to half precision, nearest and ties to even.
/// What is too large becomes the largest; NaN stays NaN.
#[inline(always)]
pub fn round<S: Simd>(simd: S, values: S::f32s, to: &mut [u16]) {
    let most = S::f32s::splat(simd, MAX * REBIAS);
    let scaled = values * SCALE;
    let cut = scaled.min_precise(most).max_precise(-most);
    // Cutting off would hide NaN.
    let bits: S::u32s = scaled.simd_eq(scaled).select(cut, scaled).bitcast();
    let magnitude = bits & 0x7fff_ffff;
    let rounded = (magnitude + ((magnitude >> 13) & 1) + 0xfff) >> 13;
    let halves = rounded | ((bits >> 16) & 0x8000);
    let mut wide = [0u32; 16];
    halves.store_slice(&mut wide[..S::u32s::LEN]);
    for (half, wide) in to.iter_mut().zip(&wide[..S::u32s::LEN]) {
        *half = *wide as u16;
    }
}

/// Rounds all of `parameters`.
#[inline(always)]
pub fn round_all<S: Simd>(simd: S, parameters: &[f32], to: &mut [u16]) {
    let n = S::f32s::LEN;
    for (values, halves) in parameters.chunks(n).zip(to.chunks_mut(n)) {
        let mut padded = [0.0; 16];
        padded[..values.len()].copy_from_slice(values);
        round(simd, S::f32s::from_slice(simd, &padded[..n]), halves);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use half::f16;

    #[test]
    fn rounds_like_the_half_crate() {
        let mut values = vec![0.0f32, -0.0, 1.0, -1.0, 300.0, -1e9, f32::INFINITY, 1e-30];
        let mut state = 1u32;
        for _ in 0..4096 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let size = 2f32.powi((state >> 27) as i32 - 22);
            values.push((state as f32 / 2f32.powi(31) - 1.0) * size);
        }
        // A tie between two neighbours, both ways.
        values.extend([1.0 + 2f32.powi(-11), 1.0 + 3.0 * 2f32.powi(-11)]);
        let mut halves = vec![0u16; values.len()];
        let level = Level::new();
        dispatch!(level, simd => round_all(simd, &values, &mut halves));
        for (value, bits) in values.iter().zip(&halves) {
            let expected = f16::from_f32((value * 256.0).clamp(-MAX, MAX));
            assert_eq!(*bits, expected.to_bits(), "{value}");
        }
        let mut nan = [0u16; 1];
        dispatch!(level, simd => round_all(simd, &[f32::NAN], &mut nan));
        assert!(f16::from_bits(nan[0]).is_nan());
    }
}
