//! Networks in half precision to fewer bytes.

use alloc::vec::Vec;

use half::f16;

use super::{BLOCK, tables};
use crate::packed::halves::{LARGE, ZERO, half};

/// Values that are all whole multiples of a power of two, as networks are that were rounded; `None`
/// for others.
pub(super) fn pack(values: &[u8]) -> Option<Vec<u8>> {
    let (values, rest) = values.as_chunks::<2>();
    if values.is_empty() || !rest.is_empty() {
        return None;
    }
    let whole = |value: &[u8; 2]| {
        let value = f16::from_le_bytes(*value).to_f32();
        (value.abs() <= 65504.0 && value == (value as i32) as f32).then_some(value as i32)
    };
    let wholes = values.iter().map(whole).collect::<Option<Vec<i32>>>()?;
    let exponent = wholes.iter().filter(|whole| **whole != 0).map(|whole| whole.trailing_zeros());
    let exponent = exponent.min().unwrap_or(0) as u8;
    let (mut large, mut codes) = (Vec::new(), Vec::with_capacity(wholes.len()));
    for (whole, value) in wholes.iter().zip(values) {
        let multiple = i16::try_from(whole >> exponent).ok()?;
        // A zero may have a sign.
        if half(multiple, exponent)?.to_le_bytes() != *value {
            return None;
        }
        match u8::try_from(i32::from(multiple) + i32::from(ZERO)) {
            Ok(code) if code != LARGE => codes.push(code),
            _ => {
                large.extend(multiple.to_le_bytes());
                codes.push(LARGE);
            }
        }
    }
    let mut packed = Vec::from([exponent]);
    packed.extend(u16::try_from(large.len() / 2).ok()?.to_le_bytes());
    packed.extend(large);
    packed.extend(tables::pack(&codes, BLOCK)?);
    Some(packed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::halves::unpack;
    use alloc::vec;

    fn bytes(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes()).collect()
    }

    #[test]
    fn multiples_by_hand() {
        // Of 16: -8, 0, 3, 127, and two that do not fit a byte.
        let packed = pack(&bytes(&[-128.0, 0.0, 48.0, 2032.0, 2048.0, -4096.0])).unwrap();
        assert_eq!(packed[..7], [4, 2, 0, 128, 0, 0, 255]);
        // A long row, in which every seventh value does not fit.
        let row: Vec<f32> =
            (0..700).map(|i| [1.0, -2.0, 0.0, 5.0, 127.0, -127.0, 300.0][i % 7]).collect();
        let row = bytes(&row);
        let packed = pack(&row).unwrap();
        assert!(packed[..3] == [0, 100, 0] && packed.len() < row.len());
        let mut back = vec![0; row.len()];
        assert!(unpack(&packed, &mut back) == Some(()) && back == row);
        // One multiple too few, one too many, half a value.
        for (n, len) in [(99, 1400), (101, 1400), (100, 1399)] {
            let mut packed = packed.clone();
            packed[1] = n;
            assert_eq!(unpack(&packed, &mut back[..len]), None, "{n}");
        }
        // One digit too many, a sign of zero, a fraction, no number.
        assert!(pack(&bytes(&[1.0, 2.0, 4097.0])).is_some());
        for odd in [-0.0, 0.5, f32::INFINITY, f32::NAN, 65504.0] {
            assert_eq!(pack(&bytes(&[1.0, odd])), None, "{odd}");
        }
    }

    #[test]
    fn every_multiple_is_what_the_half_crate_makes_of_it() {
        for exponent in 0..=15u8 {
            for multiple in -2048..=2048i16 {
                let value = f32::from(multiple) * f32::from(exponent).exp2();
                let expected = (value.abs() < 65536.0).then(|| f16::from_f32(value).to_bits());
                assert_eq!(half(multiple, exponent), expected, "{multiple} {exponent}");
            }
        }
        // Eleven digits, and twelve.
        assert_eq!(half(0x4010, 0), Some(f16::from_f32(16400.0).to_bits()));
        assert_eq!(half(0x4008, 0), None);
        assert_eq!(half(i16::MIN, 0), Some(f16::from_f32(-32768.0).to_bits()));
        let values = vec![0.0; 3];
        assert_eq!(pack(&bytes(&values)).map(|packed| packed[..3].to_vec()), Some(vec![0; 3]));
    }
}
