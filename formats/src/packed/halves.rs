//! Networks in half precision, packed: whole multiples of a power of two, most of which fit a byte.

use super::tables;

/// The code of a multiple that does not fit a byte.
pub(crate) const LARGE: u8 = 0;
/// The code of 0. Few multiples near it take few frequencies.
pub(crate) const ZERO: u8 = 128;

/// The values of a section: after the exponent of the power of two and the multiples that do not
/// fit a byte come the codes of all.
pub(crate) fn unpack(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let ([exponent, a, b], packed) = packed.split_first_chunk()?;
    let n_large = usize::from(u16::from_le_bytes([*a, *b]));
    let (large, packed) = packed.split_at_checked(2 * n_large)?;
    let mut large = large.as_chunks::<2>().0.iter();
    let n = out.len() / 2;
    if !out.len().is_multiple_of(2) {
        return None;
    }
    // In the second half: a value's two bytes are written after its code is read.
    tables::unpack(packed, &mut out[n..])?;
    for i in 0..n {
        let multiple = match out[n + i] {
            LARGE => i16::from_le_bytes(*large.next()?),
            code => i16::from(code) - i16::from(ZERO),
        };
        out[2 * i..][..2].copy_from_slice(&half(multiple, *exponent)?.to_le_bytes());
    }
    large.next().is_none().then_some(())
}

/// The bits of `multiple` times 2^`exponent` in half precision; `None` where it is too large, or
/// has more than eleven digits.
pub(crate) const fn half(multiple: i16, exponent: u8) -> Option<u16> {
    let magnitude = multiple.unsigned_abs() as u32;
    if magnitude == 0 {
        return Some(0);
    }
    let top = magnitude.ilog2();
    let exponent = top + exponent as u32;
    if exponent > 15 || top > magnitude.trailing_zeros() + 10 {
        return None;
    }
    let digits = if top > 10 { magnitude >> (top - 10) } else { magnitude << (10 - top) };
    let sign = (multiple as u16) & 0x8000;
    Some(sign | ((exponent as u16 + 15) << 10) | (digits as u16 & 0x3ff))
}
