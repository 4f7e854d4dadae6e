//! Adaptive binary range coding (Martin 1979, in the form of LZMA): the decoder.

/// Bits of a probability.
pub(crate) const PROBABILITY_BITS: u32 = 11;
/// How slowly a probability follows what has been seen.
pub(crate) const ADAPTATION: u32 = 5;
/// Below this the range grows by a byte.
pub(crate) const LEAST_RANGE: u32 = 1 << 24;

/// The probability of a zero, in 1 / 2048.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probability(pub(crate) u16);

impl Probability {
    /// Nothing is known.
    pub(crate) const EVEN: Self = Self(1 << (PROBABILITY_BITS - 1));

    /// Follows a bit that has been seen.
    #[inline(always)]
    pub(crate) const fn follow(&mut self, bit: bool) {
        if bit {
            self.0 -= self.0 >> ADAPTATION;
        } else {
            self.0 += ((1 << PROBABILITY_BITS) - self.0) >> ADAPTATION;
        }
    }
}

/// Codes bits in either direction: a writer writes the bit that it is told, a reader gives the
/// next one, whatever it is told.
#[cfg(feature = "plenoxels")]
pub(crate) trait Bits {
    /// The bit that was written or read.
    fn code(&mut self, bit: bool, probability: &mut Probability) -> bool;
}

/// Reads bits.
pub(crate) struct BitReader<'b> {
    bytes: &'b [u8],
    range: u32,
    code: u32,
}

impl<'b> BitReader<'b> {
    /// Bytes that are unread at the end: those of the writer's last range.
    pub(crate) const SLACK: usize = 4;

    /// `None` for fewer bytes than any writer gives.
    pub(crate) fn new(bytes: &'b [u8]) -> Option<Self> {
        let (first, bytes) = bytes.split_first_chunk()?;
        Some(Self { bytes, range: !0, code: u32::from_be_bytes(*first) })
    }

    /// The next bit; where bytes are missing, any.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    #[cfg_attr(target_os = "none", inline(never))] // A microcontroller has less room.
    pub(crate) fn next(&mut self, probability: &mut Probability) -> bool {
        let bound = (self.range >> PROBABILITY_BITS) * u32::from(probability.0);
        let bit = self.code >= bound;
        if bit {
            self.code -= bound;
            self.range -= bound;
        } else {
            self.range = bound;
        }
        probability.follow(bit);
        if self.range < LEAST_RANGE {
            let (next, rest) = self.bytes.split_first().unwrap_or((&0, &[]));
            (self.code, self.range) = (self.code << 8 | u32::from(*next), self.range << 8);
            self.bytes = rest;
        }
        bit
    }

    /// Whether the bytes end where the bits do.
    pub(crate) fn is_at_end(&self) -> bool {
        self.bytes.len() <= Self::SLACK
    }
}

#[cfg(feature = "plenoxels")]
impl Bits for BitReader<'_> {
    #[inline(always)]
    fn code(&mut self, _: bool, probability: &mut Probability) -> bool {
        self.next(probability)
    }
}
