//! How kernels read stored values: one implementation a data type, chosen once
//! a tile, so that no kernel asks for the type of each value.

use fearless_simd::{Bytes, Simd, SimdBase, SimdWiden, f32x4, i16x8, i32x4, u64x2};

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::F32 {}
    impl Sealed for super::F16 {}
}

/// A stored type that kernels are generic over. Sealed.
pub trait Store: sealed::Sealed + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// One stored value as bytes, at any alignment.
    type Bits: Copy + core::fmt::Debug + Send + Sync + 'static;

    /// The bytes of a tensor as values; a remainder is dropped.
    fn values(bytes: &[u8]) -> &[Self::Bits];

    /// One value, unscaled.
    fn decode(bits: Self::Bits) -> f32;

    /// What [`Store::decode4`]'s values are still to be multiplied by. Kernels
    /// fold it into a factor that they multiply by anyway.
    const FACTOR: f32;

    /// Four neighbouring values, each divided by [`Store::FACTOR`].
    fn decode4<S: Simd>(simd: S, bits: &[Self::Bits; 4]) -> f32x4<S>;
}

/// Little-endian IEEE binary32.
#[derive(Clone, Copy, Debug)]
pub struct F32;

/// Little-endian IEEE binary16.
#[derive(Clone, Copy, Debug)]
pub struct F16;

impl Store for F32 {
    type Bits = [u8; 4];
    const FACTOR: f32 = 1.0;

    #[inline(always)]
    fn values(bytes: &[u8]) -> &[[u8; 4]] {
        bytes.as_chunks::<4>().0
    }

    #[inline(always)]
    fn decode(bits: [u8; 4]) -> f32 {
        f32::from_le_bytes(bits)
    }

    #[inline(always)]
    fn decode4<S: Simd>(simd: S, bits: &[[u8; 4]; 4]) -> f32x4<S> {
        f32x4::load_array(simd, bits.map(f32::from_le_bytes))
    }
}

impl Store for F16 {
    type Bits = [u8; 2];
    /// 2^112: the difference of the two exponent biases.
    const FACTOR: f32 = f32::from_bits((112 + 127) << 23);

    #[inline(always)]
    fn values(bytes: &[u8]) -> &[[u8; 2]] {
        bytes.as_chunks::<2>().0
    }

    #[inline(always)]
    fn decode(bits: [u8; 2]) -> f32 {
        crate::tensor::f16_to_f32(u16::from_le_bytes(bits))
    }

    /// Sign and magnitude moved to f32's places; the exponent keeps f16's bias.
    #[inline(always)]
    fn decode4<S: Simd>(simd: S, bits: &[[u8; 2]; 4]) -> f32x4<S> {
        let [[a, b], [c, d], [e, f], [g, h]] = *bits;
        let quad = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
        let halves: i16x8<S> = u64x2::splat(simd, quad).bitcast();
        // The sign is extended, so that it survives the shift.
        let (wide, _) = halves.widen();
        ((wide << 13) & splat_i32(simd, 0x8fff_e000)).bitcast()
    }
}

#[inline(always)]
fn splat_i32<S: Simd>(simd: S, bits: u32) -> i32x4<S> {
    i32x4::splat(simd, bits.cast_signed())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn lanes_decode_every_finite_f16_exactly() {
        for level in crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            for bits in (0..=u16::MAX).filter(|b| b & 0x7c00 != 0x7c00) {
                let values = [bits, bits ^ 0x8000, 0, bits].map(u16::to_le_bytes);
                let lanes = decode4_at(level, &values);
                for (lane, value) in lanes.iter().zip(values) {
                    assert_eq!((lane * F16::FACTOR).to_bits(), F16::decode(value).to_bits());
                }
            }
        }
    }

    fn decode4_at(level: Level, values: &[[u8; 2]; 4]) -> [f32; 4] {
        dispatch!(level, simd => F16::decode4(simd, values).to_array())
    }
}
