//! Weights to bytes of eight bits, with a power-of-two scale.

use alloc::vec::Vec;

use pocketnerf_core::TensorView;
use pocketnerf_core::tensor::SCALE_LOG2;

use super::WriteError;
use super::f16::finite;
use crate::tensor_name::TensorName;

/// Largest magnitude that is written.
const MOST: f32 = 127.0;

/// The values as whole numbers from -127 to 127, and the `scale_log2` to read
/// them with: of the smallest power of two at which none is cut off, half of it
/// and a quarter, the one with the smallest squared error. Few values are large.
/// Rounding is to nearest, ties to even.
pub(crate) fn to_i8(name: TensorName, view: &TensorView<'_>) -> Result<(Vec<u8>, i8), WriteError> {
    let values: Vec<f32> = finite(name, view)?.collect();
    let largest = values.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    let whole = whole_scale(largest);
    if largest > MOST * power(whole) {
        return Err(WriteError::OutOfRange(name));
    }
    let least = (*SCALE_LOG2.start()).into();
    let scales = (0..3).map(|finer| (whole - finer).max(least));
    let errors = scales.map(|scale| (scale, squared_error(&values, scale)));
    let best = errors.min_by(|a, b| a.1.total_cmp(&b.1));
    let scale_log2 = best.map_or(0, |(scale, _)| scale);
    let bytes = values.iter().map(|v| stored(*v, scale_log2).cast_unsigned()).collect();
    Ok((bytes, scale_log2 as i8))
}

/// The smallest exponent at which `largest` is not cut off, where that is allowed.
fn whole_scale(largest: f32) -> i32 {
    let [least, most] = [*SCALE_LOG2.start(), *SCALE_LOG2.end()].map(i32::from);
    (least..most).find(|scale| largest <= MOST * power(*scale)).unwrap_or(most)
}

/// 2^`exponent`.
fn power(exponent: i32) -> f32 {
    f32::from_bits(((127 + exponent) as u32) << 23)
}

fn stored(value: f32, scale_log2: i32) -> i8 {
    // No method of f32 rounds without a standard library: the integers of f32
    // begin at 2^23, and an addition rounds to them, ties to even.
    const INTEGERS: f32 = 12_582_912.0;
    let scaled = (value * power(-scale_log2)).clamp(-MOST, MOST);
    (scaled + INTEGERS - INTEGERS) as i8
}

fn squared_error(values: &[f32], scale_log2: i32) -> f64 {
    let scale = power(scale_log2);
    let error = |v: &f32| f64::from(*v) - f64::from(f32::from(stored(*v, scale_log2)) * scale);
    values.iter().map(|v| error(v) * error(v)).sum()
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{DType, Layout};

    use super::*;

    fn written(values: &[f32]) -> Result<(Vec<i8>, i8), WriteError> {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let shape = [1, values.len() as u32];
        let view = TensorView::new(&bytes, DType::F32, shape, 0, Layout::RowMajor).unwrap();
        let (bytes, scale) = to_i8(TensorName::new(0, 0), &view)?;
        Ok((bytes.into_iter().map(u8::cast_signed).collect(), scale))
    }

    #[test]
    fn by_hand() {
        assert_eq!(
            written(&[127.0, -127.0, 0.4, 1.5, 2.5]),
            Ok((alloc::vec![127, -127, 0, 2, 2], 0))
        );
        // 127.5 would be cut off at scale 1.
        assert_eq!(written(&[127.5; 3]), Ok((alloc::vec![64; 3], 1)));
        assert_eq!(written(&[0.0; 2]), Ok((alloc::vec![0; 2], -60)));
        assert_eq!(written(&[0.75, -0.5]), Ok((alloc::vec![96, -64], -7)));
    }

    #[test]
    fn one_large_value_does_not_cost_all_others() {
        let mut values = alloc::vec![0.004_f32; 100_000];
        values[7] = 1.02;
        let (bytes, scale) = written(&values).unwrap();
        assert_eq!((scale, bytes[7], bytes[0]), (-8, 127, 1));
    }

    #[test]
    fn refuses_what_has_no_bytes() {
        let name = TensorName::new(0, 0);
        assert_eq!(written(&[f32::NAN]), Err(WriteError::NotFinite(name)));
        assert_eq!(written(&[1e30]), Err(WriteError::OutOfRange(name)));
    }
}
