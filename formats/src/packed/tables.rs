//! Tables of bytes, packed: static range variants of asymmetric numeral systems (Duda 2013), one
//! frequency table a section, in chunks that stand alone.

/// Bits of a frequency.
pub(crate) const FREQUENCY_BITS: u32 = 12;
/// Sum of all frequencies.
pub(crate) const TOTAL: u32 = 1 << FREQUENCY_BITS;
/// Values of a chunk.
pub(crate) const CHUNK: usize = 1 << 13;
/// A state is at least this, and below its square.
pub(crate) const LEAST_STATE: u32 = 1 << 16;
/// Bits of the table that finds a symbol; the rest is a search. A microcontroller has less room.
const FIND_BITS: u32 = if cfg!(feature = "std") { FREQUENCY_BITS } else { 8 };

/// How often each byte occurs.
struct Frequencies {
    /// Frequencies of all bytes below, [`TOTAL`] at the end.
    below: [u16; 257],
    /// The byte at which the search for each slot begins.
    find: [u8; 1 << FIND_BITS],
}

impl Frequencies {
    /// From the first bytes of a section, which are taken off: first and last byte that occurs,
    /// then the frequency of each of these and those between, seven bits a byte.
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let ([first, last], mut rest) = bytes.split_first_chunk().map(|(b, r)| (*b, r))?;
        let mut below = [0u16; 257];
        let mut sum = 0u32;
        for (byte, below) in (0..=255u8).zip(&mut below) {
            *below = sum as u16;
            if (first..=last).contains(&byte) {
                let (low, after) = rest.split_first()?;
                rest = after;
                sum += u32::from(*low & 0x7f);
                if *low >= 0x80 {
                    let (high, after) = rest.split_first()?;
                    rest = after;
                    sum += u32::from(*high) << 7;
                }
                if sum > TOTAL {
                    return None;
                }
            }
        }
        below[256] = sum as u16;
        if sum != TOTAL {
            return None;
        }
        let mut find = [0; 1 << FIND_BITS];
        let mut symbol = 0;
        for (i, found) in find.iter_mut().enumerate() {
            let slot = (i << (FREQUENCY_BITS - FIND_BITS)) as u16;
            while below[symbol + 1] <= slot {
                symbol += 1;
            }
            *found = symbol as u8;
        }
        *bytes = rest;
        Some(Self { below, find })
    }

    /// The byte that a state begins with, and the state after it.
    #[inline(always)]
    fn decode(&self, state: u32) -> (u8, u32) {
        let slot = state & (TOTAL - 1);
        let mut symbol = self.find[(slot >> (FREQUENCY_BITS - FIND_BITS)) as usize];
        if FIND_BITS < FREQUENCY_BITS {
            while u32::from(self.below[usize::from(symbol) + 1]) <= slot {
                symbol += 1;
            }
        }
        let [low, high] = [0, 1].map(|i| u32::from(self.below[usize::from(symbol) + i]));
        (symbol, (high - low) * (state >> FREQUENCY_BITS) + slot - low)
    }
}

/// The values of all chunks.
pub(super) fn unpack(mut packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (block, rest) = packed.split_first()?;
    packed = rest;
    let block = usize::from(*block);
    if block == 0 {
        return None;
    }
    let frequencies = Frequencies::read(&mut packed)?;
    let lengths = packed.get(..2 * out.len().div_ceil(CHUNK))?.as_chunks::<2>().0;
    packed = &packed[2 * lengths.len()..];
    for (chunk, length) in out.chunks_mut(CHUNK).zip(lengths) {
        let (own, rest) = packed.split_at_checked(u16::from_le_bytes(*length).into())?;
        match own.is_empty() {
            true => chunk.fill(0),
            false => unpack_chunk(own, &frequencies, block, chunk)?,
        }
        packed = rest;
    }
    packed.is_empty().then_some(())
}

/// The values of a chunk, in blocks of which some may be all 0.
fn unpack_chunk(
    packed: &[u8],
    frequencies: &Frequencies,
    block: usize,
    out: &mut [u8],
) -> Option<()> {
    let ([some_empty], packed) = packed.split_first_chunk()?;
    let n_flags = if *some_empty == 0 { 0 } else { out.len().div_ceil(block).div_ceil(8) };
    let (empty, packed) = packed.split_at_checked(n_flags)?;
    let (states, packed) = packed.split_first_chunk::<8>()?;
    let [a, b, c, d, e, f, g, h] = *states;
    let mut states = [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])];
    let (words, rest) = packed.as_chunks::<2>();
    let mut words = words.iter();
    let mut step = |state: &mut u32| {
        let (symbol, next) = frequencies.decode(*state);
        *state = match next < LEAST_STATE {
            // Where words are missing the states do not end as they began.
            true => next << 16 | u32::from(u16::from_le_bytes(*words.next().unwrap_or(&[0; 2]))),
            false => next,
        };
        symbol
    };
    for (i, values) in out.chunks_mut(block).enumerate() {
        if empty.get(i / 8).is_some_and(|flags| flags >> (i % 8) & 1 == 1) {
            values.fill(0);
            continue;
        }
        let (pairs, odd) = values.as_chunks_mut::<2>();
        for pair in pairs {
            *pair = [step(&mut states[0]), step(&mut states[1])];
        }
        for value in odd {
            *value = step(&mut states[0]);
        }
    }
    (states == [LEAST_STATE; 2] && words.next().is_none() && rest.is_empty()).then_some(())
}
