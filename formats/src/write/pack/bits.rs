//! Adaptive binary range coding: the encoder.

use alloc::vec::Vec;

use crate::packed::bits::{LEAST_RANGE, PROBABILITY_BITS, Probability};

/// Writes bits.
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    low: u64,
    range: u32,
    /// The last byte, to which something may have to be carried, and how many 0xff follow it.
    last: Option<u8>,
    full: usize,
}

impl BitWriter {
    /// After these bytes.
    pub(super) const fn new(bytes: Vec<u8>) -> Self {
        Self { bytes, low: 0, range: !0, last: None, full: 0 }
    }

    pub(super) fn push(&mut self, bit: bool, probability: &mut Probability) {
        let bound = (self.range >> PROBABILITY_BITS) * u32::from(probability.0);
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        probability.follow(bit);
        if self.range < LEAST_RANGE {
            self.range <<= 8;
            self.shift();
        }
    }

    /// Takes off the highest byte of `low`.
    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        let byte = (self.low >> 24) as u8;
        if byte == 0xff && carry == 0 {
            self.full += 1;
        } else {
            self.bytes.extend(self.last.map(|last| last.wrapping_add(carry)));
            self.bytes.extend(core::iter::repeat_n(0xffu8.wrapping_add(carry), self.full));
            (self.last, self.full) = (Some(byte), 0);
        }
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    /// All bytes: those that decide the last bit among them.
    pub(super) fn finish(mut self) -> Vec<u8> {
        for _ in 0..4 {
            self.shift();
        }
        self.bytes.extend(self.last);
        self.bytes.extend(core::iter::repeat_n(0xff, self.full));
        self.bytes
    }
}

#[cfg(feature = "plenoxels")]
impl crate::packed::bits::Bits for BitWriter {
    fn code(&mut self, bit: bool, probability: &mut Probability) -> bool {
        self.push(bit, probability);
        bit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits of every kind of surprise come back, carries through many 0xff among them.
    #[test]
    fn what_is_written_is_read() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        for one_in in [2, 3, 50, 1000, u32::MAX] {
            for n in [0, 1, 2, 100, 50_000] {
                let bits: Vec<bool> = (0..n).map(|_| random() % one_in == 1).collect();
                let mut probability = Probability::EVEN;
                let mut writer = BitWriter::new(Vec::new());
                bits.iter().for_each(|bit| writer.push(*bit, &mut probability));
                let bytes = writer.finish();
                let mut reader = crate::packed::bits::BitReader::new(&bytes).unwrap();
                let mut probability = Probability::EVEN;
                assert!(bits.iter().all(|bit| reader.next(&mut probability) == *bit));
                assert!(reader.is_at_end(), "{one_in} {n}");
            }
        }
    }
}
