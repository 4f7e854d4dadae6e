//! How parameters are rounded for the forward pass of training.

use fearless_simd::{Bytes, Select, Simd, SimdBase};
use pocketnerf_core::tensor::SCALE_LOG2;

/// How parameters are rounded.
pub trait Rounding: Copy {
    /// A rounded parameter.
    type Bits: Copy;

    /// Rounds a register of parameters.
    fn round<S: Simd>(self, simd: S, values: S::f32s, to: &mut [Self::Bits]);

    /// Rounds all of `parameters`.
    #[inline(always)]
    fn round_all<S: Simd>(self, simd: S, parameters: &[f32], to: &mut [Self::Bits]) {
        let n = S::f32s::LEN;
        for (values, to) in parameters.chunks(n).zip(to.chunks_mut(n)) {
            let mut padded = [0.0; 16];
            padded[..values.len()].copy_from_slice(values);
            self.round(simd, S::f32s::from_slice(simd, &padded[..n]), to);
        }
    }
}

/// Not at all.
#[derive(Clone, Copy, Debug)]
pub struct Unrounded;

impl Rounding for Unrounded {
    type Bits = ();

    #[inline(always)]
    fn round<S: Simd>(self, _: S, _: S::f32s, _: &mut [()]) {}

    #[inline(always)]
    fn round_all<S: Simd>(self, _: S, _: &[f32], _: &mut [()]) {}
}

/// To half precision, nearest and ties to even. What is too large becomes the
/// largest; NaN stays NaN. For networks.
#[derive(Clone, Copy, Debug)]
pub struct Half;

impl Half {
    /// Exponent of the unit of the stored values: nothing that is learnt comes
    /// near 255.
    pub const SCALE_LOG2: i8 = -8;
}

/// f16's largest number.
const MAX: f32 = 65504.0;
/// 2^(8 − 112): the unit and the difference of f32's and f16's exponent biases.
const SCALE: f32 = power(-112 - Half::SCALE_LOG2 as i32);
/// 2^−112.
const REBIAS: f32 = power(-112);

/// 2^`exponent`.
const fn power(exponent: i32) -> f32 {
    f32::from_bits(((127 + exponent) as u32) << 23)
}

impl Rounding for Half {
    type Bits = u16;

    #[inline(always)]
    fn round<S: Simd>(self, simd: S, values: S::f32s, to: &mut [u16]) {
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
}

/// Of a step, so much is too small to become one where steps are longer than a unit: zeros take
/// few bits (a dead zone, as video encoders have one).
pub const DEAD_ZONE: f32 = 0.62;

/// To whole multiples of a power of two that fit a byte, from -127 to 127, nearest
/// and ties to even; what lies beyond becomes the largest, NaN anything. For tables.
///
/// Where a model may take few bytes, to multiples of a step of several units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EightBits {
    /// Exponent of the unit of the stored values.
    scale_log2: i8,
    /// Units of a step.
    step: u8,
}

impl EightBits {
    /// For magnitudes up to 2^-17: entries begin larger, and as different numbers.
    pub const FINEST: Self = Self { scale_log2: -24, step: 1 };
    /// The coarsest that model files know.
    const COARSEST: Self = Self { scale_log2: *SCALE_LOG2.end(), step: 1 };
    /// Largest magnitude, in units.
    const MOST: f32 = 127.0;

    /// At this exponent, `None` where no run would have come to it.
    #[must_use]
    pub fn at(scale_log2: i8) -> Option<Self> {
        let sound = Self::FINEST.scale_log2..=Self::COARSEST.scale_log2;
        sound.contains(&scale_log2).then_some(Self { scale_log2, step: 1 })
    }

    /// Of `n` tables, as a checkpoint holds them: exponents, and perhaps steps, which is said too;
    /// `None` for bytes that no run gives.
    #[must_use]
    pub fn all_of(bytes: &[u8], n: usize) -> Option<(Vec<Self>, bool)> {
        let (units, steps) = bytes.split_at_checked(n)?;
        let coarse = !steps.is_empty();
        if coarse && steps.len() != n {
            return None;
        }
        let steps = steps.iter().copied().chain(std::iter::repeat(1));
        let scale = |(unit, step): (&u8, u8)| Self::at(unit.cast_signed())?.with_step(step);
        let scales: Option<Vec<Self>> = units.iter().zip(steps).map(scale).collect();
        Some((scales?, coarse))
    }

    /// Exponent of the unit of the stored values.
    #[must_use]
    pub const fn scale_log2(self) -> i8 {
        self.scale_log2
    }

    /// Units of a step.
    #[must_use]
    pub const fn step(self) -> u8 {
        self.step
    }

    /// How long a step is.
    #[must_use]
    pub fn length(self) -> f32 {
        f32::from(self.step) * power(self.scale_log2.into())
    }

    /// With steps of so many units, `None` where no value but 0 would be left.
    #[must_use]
    pub fn with_step(self, step: u8) -> Option<Self> {
        (1..=Self::MOST as u8).contains(&step).then_some(Self { step, ..self })
    }

    /// With steps of about this length, a unit at least.
    #[must_use]
    pub fn with_step_of(self, length: f32) -> Self {
        let step = (length * power(-i32::from(self.scale_log2))).round().clamp(1.0, Self::MOST);
        Self { step: step as u8, ..self }
    }

    /// Becomes as coarse as values of this magnitude need; says whether it was not
    /// before. Steps stay about as long as they are.
    pub fn hold(&mut self, largest: f32) -> bool {
        let before = *self;
        let most = Self::COARSEST.scale_log2;
        while largest > Self::MOST * power(self.scale_log2.into()) && self.scale_log2 != most {
            self.scale_log2 += 1;
            self.step = self.step.div_ceil(2);
        }
        *self != before
    }
}

impl Rounding for EightBits {
    type Bits = u8;

    #[inline(always)]
    fn round<S: Simd>(self, simd: S, values: S::f32s, to: &mut [u8]) {
        // The integers of f32 begin at 2^23: an addition rounds to them, and the
        // lowest byte is that of the integer.
        const INTEGERS: f32 = 12_582_912.0;
        let scaled = values * power(-i32::from(self.scale_log2));
        let whole = if self.step == 1 {
            let most = S::f32s::splat(simd, Self::MOST);
            scaled.min_precise(most).max_precise(-most) + INTEGERS
        } else {
            let step = f32::from(self.step);
            let most = S::f32s::splat(simd, (Self::MOST / step).floor());
            let steps = (scaled * (1.0 / step)).min_precise(most).max_precise(-most);
            let dead = steps.abs().simd_lt(S::f32s::splat(simd, DEAD_ZONE));
            let whole = (steps + INTEGERS) - INTEGERS;
            dead.select(S::f32s::splat(simd, 0.0), whole) * step + INTEGERS
        };
        let mut wide = [0u32; 16];
        whole.bitcast::<S::u32s>().store_slice(&mut wide[..S::u32s::LEN]);
        for (byte, wide) in to.iter_mut().zip(&wide[..S::u32s::LEN]) {
            *byte = *wide as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use half::f16;

    /// Numbers of many sizes, both signs, and some beyond what can be held.
    fn numbers() -> Vec<f32> {
        let mut values = vec![0.0f32, -0.0, 1.0, -1.0, 300.0, -1e9, f32::INFINITY, 1e-30];
        let mut state = 1u32;
        for _ in 0..4096 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let size = 2f32.powi((state >> 27) as i32 - 22);
            values.push((state as f32 / 2f32.powi(31) - 1.0) * size);
        }
        // A tie between two neighbours, both ways.
        values.extend([1.0 + 2f32.powi(-11), 1.0 + 3.0 * 2f32.powi(-11)]);
        values
    }

    #[test]
    fn halves_are_those_of_the_half_crate() {
        let values = numbers();
        let mut halves = vec![0u16; values.len()];
        let level = Level::new();
        dispatch!(level, simd => Half.round_all(simd, &values, &mut halves));
        for (value, bits) in values.iter().zip(&halves) {
            let expected = f16::from_f32((value * 256.0).clamp(-MAX, MAX));
            assert_eq!(*bits, expected.to_bits(), "{value}");
        }
        let mut nan = [0u16; 1];
        dispatch!(level, simd => Half.round_all(simd, &[f32::NAN], &mut nan));
        assert!(f16::from_bits(nan[0]).is_nan());
    }

    #[test]
    fn bytes_are_the_nearest_multiples() {
        let mut values = numbers();
        values.extend([0.5, 1.5, 2.5, -0.5, -1.5, 126.5, 127.5].map(|v| v / 128.0));
        let scale = EightBits::at(-7).unwrap();
        for level in pocketnerf_core::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            let mut bytes = vec![0u8; values.len()];
            dispatch!(level, simd => scale.round_all(simd, &values, &mut bytes));
            for (value, byte) in values.iter().zip(&bytes) {
                let expected = (value * 128.0).round_ties_even().clamp(-127.0, 127.0);
                assert_eq!(f32::from(byte.cast_signed()), expected, "{level:?} {value}");
            }
        }
    }

    #[test]
    fn steps_are_multiples_beyond_a_dead_zone() {
        let scale = EightBits::at(-7).unwrap().with_step(12).unwrap();
        // 0.6 and 0.64 of a step, one and a half, the largest multiple and what lies beyond it.
        let units = [0.0f32, 7.2, 7.68, -7.68, 18.1, -40.0, 120.0, 500.0, -500.0];
        let expected = [0.0, 0.0, 12.0, -12.0, 24.0, -36.0, 120.0, 120.0, -120.0];
        let values = units.map(|unit| unit / 128.0);
        for level in pocketnerf_core::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok()) {
            let mut bytes = [0u8; 9];
            dispatch!(level, simd => scale.round_all(simd, &values, &mut bytes));
            assert_eq!(bytes.map(|byte| f32::from(byte.cast_signed())), expected, "{level:?}");
        }
        assert_eq!((scale.with_step(0), scale.with_step(128)), (None, None));
        assert_eq!(EightBits::at(-7).unwrap().with_step_of(12.3 / 128.0), scale);
        assert_eq!(scale.with_step_of(1e-9).step(), 1);
        // Of units twice as large, half as many.
        let mut grown = scale;
        assert!(grown.hold(1.0) && (grown.scale_log2(), grown.step()) == (-6, 6));
    }

    #[test]
    fn units_grow_with_what_they_have_to_hold() {
        let mut scale = EightBits::FINEST;
        assert!(!scale.hold(0.0) && !scale.hold(f32::NAN));
        // 127 units of 2^-7, and a little more.
        assert!(scale.hold(127.0 / 128.0));
        assert_eq!(scale.scale_log2(), -7);
        assert!(!scale.hold(127.0 / 128.0) && !scale.hold(0.1));
        assert!(scale.hold(1.0));
        assert_eq!(scale.scale_log2(), -6);
        assert!(scale.hold(f32::INFINITY) && !scale.hold(f32::INFINITY));
        assert_eq!(Some(scale), EightBits::at(*SCALE_LOG2.end()));
        assert_eq!(EightBits::at(-25), None);
    }
}
