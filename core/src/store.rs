//! How kernels read stored values: one implementation a data type, chosen once
//! a tile, so that no kernel asks for the type of each value.

use fearless_simd::{Bytes, Simd, SimdBase, SimdInt, f32x4, i32x4};

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::F32 {}
    impl Sealed for super::F16 {}
    impl Sealed for super::I8 {}
}

/// A stored type that kernels are generic over. Sealed.
pub trait Store: sealed::Sealed + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// One stored value as bytes, at any alignment.
    type Bits: Copy + core::fmt::Debug + Send + Sync + 'static;

    /// The bytes of a tensor as values; a remainder is dropped.
    fn values(bytes: &[u8]) -> &[Self::Bits];

    /// One value, unscaled.
    fn decode(bits: Self::Bits) -> f32;

    /// Four neighbouring values as they are stored.
    type Quad: Copy + Default + core::fmt::Debug;

    /// Reads four values without decoding them.
    fn quad(bits: &[Self::Bits; 4]) -> Self::Quad;

    /// What [`Store::decode_divided`]'s and [`Store::decode_quads`]'s values are
    /// still to be multiplied by. Kernels fold it into a factor that they
    /// multiply by anyway.
    const FACTOR: f32;

    /// One finite value, divided by [`Store::FACTOR`].
    fn decode_divided(bits: Self::Bits) -> f32;

    /// Eight finite values, divided by [`Store::FACTOR`].
    #[inline(always)]
    fn decode_eight<S: Simd>(_: S, bits: &[Self::Bits; 8]) -> [f32; 8] {
        core::array::from_fn(|i| Self::decode_divided(bits[i]))
    }

    /// Decodes a register's length of quads: the first value of each, the second,
    /// the third, the fourth, all divided by [`Store::FACTOR`].
    fn decode_quads<S: Simd>(simd: S, quads: &[Self::Quad]) -> [S::f32s; 4];
}

/// Little-endian IEEE binary32.
#[derive(Clone, Copy, Debug)]
pub struct F32;

/// Little-endian IEEE binary16.
#[derive(Clone, Copy, Debug)]
pub struct F16;

/// Whole numbers of eight bits.
#[derive(Clone, Copy, Debug)]
pub struct I8;

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
    fn decode_divided(bits: [u8; 4]) -> f32 {
        f32::from_le_bytes(bits)
    }

    type Quad = [f32; 4];

    #[inline(always)]
    fn quad(bits: &[[u8; 4]; 4]) -> [f32; 4] {
        bits.map(f32::from_le_bytes)
    }

    #[inline(always)]
    fn decode_quads<S: Simd>(simd: S, quads: &[[f32; 4]]) -> [S::f32s; 4] {
        let n = S::f32s::LEN;
        let flat = quads.as_flattened();
        let load = |i: usize| S::f32s::from_slice(simd, &flat[i * n..(i + 1) * n]);
        let (even_a, odd_a) = load(0).deinterleave(load(1));
        let (even_b, odd_b) = load(2).deinterleave(load(3));
        let ((a, c), (b, d)) = (even_a.deinterleave(even_b), odd_a.deinterleave(odd_b));
        [a, b, c, d]
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

    #[inline(always)]
    fn decode_divided(bits: [u8; 2]) -> f32 {
        let pair = u32::from(u16::from_le_bytes(bits)) << 16;
        f32::from_bits((pair.cast_signed() >> 3).cast_unsigned() & UPPER)
    }

    /// Two to a lane: compilers decode one after the other.
    #[inline(always)]
    fn decode_eight<S: Simd>(simd: S, bits: &[[u8; 2]; 8]) -> [f32; 8] {
        let twos = core::array::from_fn(|i| {
            let [[a, b], [c, d]] = [bits[2 * i], bits[2 * i + 1]];
            i32::from_le_bytes([a, b, c, d])
        });
        let twos = i32x4::load_array(simd, twos);
        let (front, back) = (twos << 16).interleave(twos);
        let mut decoded = [0.0; 8];
        for (four, to) in [front, back].into_iter().zip(decoded.as_chunks_mut::<4>().0) {
            let four: f32x4<S> = ((four >> 3) & UPPER.cast_signed()).bitcast();
            four.store_array(to);
        }
        decoded
    }

    type Quad = u64;

    #[inline(always)]
    fn quad(bits: &[[u8; 2]; 4]) -> u64 {
        let [[a, b], [c, d], [e, f], [g, h]] = *bits;
        u64::from_le_bytes([a, b, c, d, e, f, g, h])
    }

    #[inline(always)]
    fn decode_quads<S: Simd>(simd: S, quads: &[u64]) -> [S::f32s; 4] {
        let n = S::f32s::LEN;
        let load =
            |at: usize| -> S::i32s { S::u64s::from_slice(simd, &quads[at..at + n / 2]).bitcast() };
        let (ab, cd) = load(0).deinterleave(load(n / 2));
        [upper::<S>(ab << 16), upper::<S>(ab), upper::<S>(cd << 16), upper::<S>(cd)]
    }
}

impl Store for I8 {
    type Bits = u8;
    /// 2^-24: numbers are left in the uppermost byte of an integer.
    const FACTOR: f32 = f32::from_bits((127 - 24) << 23);

    #[inline(always)]
    fn values(bytes: &[u8]) -> &[u8] {
        bytes
    }

    #[inline(always)]
    fn decode(bits: u8) -> f32 {
        f32::from(bits.cast_signed())
    }

    #[inline(always)]
    fn decode_divided(bits: u8) -> f32 {
        (i32::from(bits.cast_signed()) << 24) as f32
    }

    type Quad = u32;

    #[inline(always)]
    fn quad(bits: &[u8; 4]) -> u32 {
        u32::from_le_bytes(*bits)
    }

    #[inline(always)]
    fn decode_quads<S: Simd>(simd: S, quads: &[u32]) -> [S::f32s; 4] {
        let all: S::i32s = S::u32s::from_slice(simd, quads).bitcast();
        let upper = |shifted: S::i32s| (shifted & (0xff << 24)).to_float::<S::f32s>();
        [(all << 24).to_float::<S::f32s>(), upper(all << 16), upper(all << 8), upper(all)]
    }
}

/// Where f32 has an f16's sign (repeated), magnitude and the exponent's low bits.
const UPPER: u32 = 0x8fff_e000;

/// The f16 in the upper half of each lane: sign and magnitude moved to f32's
/// places (the sign is extended, so that it survives the shift); the exponent
/// keeps f16's bias.
#[inline(always)]
fn upper<S: Simd>(pair: S::i32s) -> S::f32s {
    ((pair >> 3) & UPPER.cast_signed()).bitcast()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;

    #[test]
    fn lanes_decode_every_value_exactly() {
        for level in crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            for bits in (0..=u16::MAX).filter(|b| b & 0x7c00 != 0x7c00) {
                let values = [bits, bits ^ 0x8000, 0, bits].map(u16::to_le_bytes);
                let lanes = dispatch!(level, simd => same_in_every_lane::<_, F16>(simd, &values));
                for (lane, value) in lanes.iter().zip(values) {
                    assert_eq!((lane * F16::FACTOR).to_bits(), F16::decode(value).to_bits());
                    assert_eq!(F16::decode_divided(value).to_bits(), lane.to_bits());
                }
                let mut eight = [[0; 2]; 8];
                eight[1..5].copy_from_slice(&values);
                let decoded = dispatch!(level, simd => F16::decode_eight(simd, &eight));
                for (found, value) in decoded.iter().zip(eight) {
                    assert_eq!(found.to_bits(), F16::decode_divided(value).to_bits());
                }
            }
            for byte in 0..=u8::MAX {
                let values = [byte, !byte, 0x80, byte.wrapping_mul(37)];
                let lanes = dispatch!(level, simd => same_in_every_lane::<_, I8>(simd, &values));
                assert_eq!(lanes.map(|v| v * I8::FACTOR), values.map(I8::decode));
                assert_eq!(lanes, values.map(I8::decode_divided));
            }
            let values = [1.0f32, -2.5, 0.0, 1e-30].map(f32::to_le_bytes);
            let lanes = dispatch!(level, simd => same_in_every_lane::<_, F32>(simd, &values));
            assert_eq!(lanes, [1.0, -2.5, 0.0, 1e-30]);
        }
    }

    #[inline(always)]
    fn same_in_every_lane<S: Simd, T: Store>(simd: S, values: &[T::Bits; 4]) -> [f32; 4] {
        let quads = [T::quad(values); 16];
        T::decode_quads(simd, &quads[..S::f32s::LEN]).map(|register| {
            let mut lanes = [0.0; 16];
            register.store_slice(&mut lanes[..S::f32s::LEN]);
            assert!(lanes[..S::f32s::LEN].iter().all(|lane| *lane == lanes[0]));
            lanes[0]
        })
    }
}
