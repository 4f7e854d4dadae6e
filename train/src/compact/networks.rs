//! Networks in half precision: rounded, and what they take when they are packed.

use half::f16;

use super::tables;

/// Values in half precision, each the nearest multiple of `step`, a power of two; ties to even,
/// zeros without a sign.
pub(super) fn rounded(values: &[u8], step: u16) -> Vec<u8> {
    if step == 1 {
        return values.to_vec();
    }
    let step = f32::from(step);
    let round = |value: &[u8; 2]| {
        let multiple = (f16::from_le_bytes(*value).to_f32() / step).round_ties_even();
        // A negative zero becomes a positive one.
        f16::from_f32(multiple * step + 0.0).to_le_bytes()
    };
    values.as_chunks::<2>().0.iter().flat_map(round).collect()
}

/// Bytes that these multiples of `step` take, packed, about.
pub(super) fn rate(values: &[u8], step: u16) -> f64 {
    if step == 1 {
        return values.len() as f64;
    }
    let multiple = |value: &[u8; 2]| f16::from_le_bytes(*value).to_f32() / f32::from(step);
    let multiples = values.as_chunks::<2>().0.iter().map(multiple);
    let n_large = multiples.clone().filter(|multiple| multiple.abs() > 127.0).count();
    let codes: Vec<u8> = multiples.map(|multiple| (multiple + 128.0) as u8).collect();
    tables::rate(&codes, 4) + 2.0 * n_large as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_by_hand() {
        let values = [0.0, -0.0, 15.0, -7.9, -8.0, 24.0, 1000.0, -32768.0].map(f16::from_f32);
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let of = |step| {
            let rounded = rounded(&bytes, step);
            let values = rounded.as_chunks::<2>().0.iter();
            values.map(|value| f16::from_le_bytes(*value).to_f32()).collect::<Vec<_>>()
        };
        assert_eq!(of(16), [0.0, 0.0, 16.0, 0.0, 0.0, 32.0, 992.0, -32768.0]);
        assert!(of(16).iter().all(|value| *value != 0.0 || value.is_sign_positive()));
        assert!(rounded(&bytes, 1) == bytes);
    }

    #[test]
    fn entropy_by_hand() {
        // Half 4, half -4: a bit each; one more that does not fit a byte.
        let values: Vec<f16> = (0..8192).map(|i| f16::from_f32([4.0, -4.0][i % 2])).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        assert!((rate(&bytes, 4) - (1024.0 + 3.0 + 43.0)).abs() < 1e-9);
        assert_eq!(rate(&bytes, 1), 16384.0);
    }
}
