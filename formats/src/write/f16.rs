//! Weights to bytes: f32, or f16 with a power-of-two scale.

use alloc::vec::Vec;

use half::f16;
use half::slice::HalfFloatSliceExt;
use pocketnerf_core::TensorView;
use pocketnerf_core::tensor::SCALE_LOG2;

use super::WriteError;
use crate::tensor_name::TensorName;

/// The values as little-endian f32, unscaled.
pub(crate) fn to_f32(name: TensorName, view: &TensorView<'_>) -> Result<Vec<u8>, WriteError> {
    let mut bytes = Vec::with_capacity(4 * values(view).len());
    for value in finite(name, view)? {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    Ok(bytes)
}

/// The values as little-endian f16, and the `scale_log2` to read them with.
///
/// The largest magnitude is scaled into [2^14, 2^15): as far as possible from
/// f16's subnormals, with room below infinity. Rounding is to nearest, ties to
/// even; values that would still be subnormal become zero.
pub(crate) fn to_f16(name: TensorName, view: &TensorView<'_>) -> Result<(Vec<u8>, i8), WriteError> {
    let largest = finite(name, view)?.fold(0.0f32, |m, v| m.max(v.abs()));
    let scale_log2 = scale_log2(largest);
    // A power of two: the product is exact unless it is far below f16's range.
    let scale = f32::from_bits(((127 - i32::from(scale_log2)) as u32) << 23);
    if largest * scale > f16::MAX.to_f32_const() {
        return Err(WriteError::OutOfRange(name));
    }
    let mut bytes = Vec::with_capacity(2 * values(view).len());
    let mut indices = values(view);
    // Converting in slices is ten times as fast as value by value.
    let (mut wide, mut narrow) = ([0.0f32; 256], [f16::ZERO; 256]);
    while !indices.is_empty() {
        let n = indices.len().min(wide.len());
        for (value, index) in wide[..n].iter_mut().zip(&mut indices) {
            *value = view.get(index) * scale;
        }
        narrow[..n].convert_from_f32_slice(&wide[..n]);
        for value in &narrow[..n] {
            let value = if value.is_normal() { *value } else { f16::ZERO };
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }
    Ok((bytes, scale_log2))
}

/// The exponent that brings `largest` to [2^14, 2^15), where that is allowed.
fn scale_log2(largest: f32) -> i8 {
    if largest == 0.0 {
        return 0;
    }
    let exponent = (largest.to_bits() >> 23) as i32 - 127;
    (exponent - 14).clamp((*SCALE_LOG2.start()).into(), (*SCALE_LOG2.end()).into()) as i8
}

/// Numbers of a tensor's values.
pub(crate) fn values(view: &TensorView<'_>) -> core::ops::Range<usize> {
    0..view.rows() * view.cols()
}

/// The values, once all are known to be finite.
pub(crate) fn finite<'v>(
    name: TensorName,
    view: &'v TensorView<'_>,
) -> Result<impl Iterator<Item = f32> + 'v, WriteError> {
    // Stored values decide first: f16 infinities would decode to numbers.
    let ok = view.is_finite() && values(view).all(|i| view.get(i).is_finite());
    if ok { Ok(values(view).map(|i| view.get(i))) } else { Err(WriteError::NotFinite(name)) }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{DType, Layout};

    use super::*;

    const NAME: TensorName = TensorName::new(0, 0);

    fn bytes(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn view(bytes: &[u8]) -> TensorView<'_> {
        let n = bytes.len() as u32 / 4;
        TensorView::new(bytes, DType::F32, [1, n], 0, Layout::RowMajor).unwrap()
    }

    fn round_trip(values: &[f32]) -> (Vec<f32>, i8) {
        let (stored, scale) = to_f16(NAME, &view(&bytes(values))).unwrap();
        let shape = [1, values.len() as u32];
        let back = TensorView::new(&stored, DType::F16, shape, scale, Layout::RowMajor).unwrap();
        ((0..values.len()).map(|i| back.get(i)).collect(), scale)
    }

    #[test]
    fn scale_brings_the_largest_value_just_below_2_15() {
        for (largest, scale) in [
            (0.0, 0),
            (1.0, -14),
            (1.999_999_9, -14),
            (2.0, -13),
            (16384.0, 0),
            (1e-4, -28),
            (65535.0, 1),
            (f32::MIN_POSITIVE / 4.0, -60),
            (f32::MAX, 14),
        ] {
            assert_eq!(scale_log2(largest), scale, "{largest}");
        }
    }

    #[test]
    fn keeps_eleven_bits_of_small_weights() {
        // The start of a hash grid: ±1e-4. Unscaled f16 would keep nine bits.
        let values: Vec<f32> = (0..1000u32).map(|i| (i as f32 - 499.5) * 2e-7).collect();
        let (back, scale) = round_trip(&values);
        assert_eq!(scale, -28);
        for (v, b) in values.iter().zip(back) {
            assert!((v - b).abs() <= v.abs() / 2048.0, "{v} {b}");
        }
    }

    #[test]
    fn rounds_to_even_and_flushes_what_stays_subnormal() {
        // Largest 1: one unit of the stored 2^14 is 2^-10 of it.
        let half_unit = 1.0 / 2048.0;
        let tiny = 1.0 / (1u64 << 29) as f32;
        let (back, _) = round_trip(&[1.0, 1.0 - half_unit / 2.0, tiny, -tiny, 2.0 * tiny]);
        assert_eq!(back, [1.0, 1.0, 0.0, 0.0, 2.0 * tiny]);
        assert!(back[3].is_sign_positive());
        let (back, _) = round_trip(&[1.0 + half_unit, 1.0 + 3.0 * half_unit]);
        assert_eq!(back, [1.0, 1.0 + 4.0 * half_unit]);
    }

    #[test]
    fn f16_again_gives_the_same_bytes() {
        let values: Vec<f32> = (1..300).map(|i| 1.0 / i as f32).collect();
        let (once, scale) = to_f16(NAME, &view(&bytes(&values))).unwrap();
        let shape = [1, values.len() as u32];
        let view = TensorView::new(&once, DType::F16, shape, scale, Layout::RowMajor).unwrap();
        assert_eq!(to_f16(NAME, &view), Ok((once.clone(), scale)));
    }

    #[test]
    fn refuses_what_has_no_bytes() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let values = bytes(&[0.0, bad]);
            assert_eq!(to_f16(NAME, &view(&values)), Err(WriteError::NotFinite(NAME)));
            assert_eq!(to_f32(NAME, &view(&values)), Err(WriteError::NotFinite(NAME)));
        }
        let huge = bytes(&[1e30]);
        assert_eq!(to_f16(NAME, &view(&huge)), Err(WriteError::OutOfRange(NAME)));
        assert_eq!(to_f32(NAME, &view(&huge)), Ok(huge.clone()));
    }
}
