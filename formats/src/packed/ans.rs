//! Range variants of asymmetric numeral systems (Duda 2013) with two interleaved states: the
//! decoder.

/// Bits of a frequency.
pub(crate) const FREQUENCY_BITS: u32 = 12;
/// Sum of all frequencies.
pub(crate) const TOTAL: u32 = 1 << FREQUENCY_BITS;
/// A state is at least this, and below its square.
pub(crate) const LEAST_STATE: u32 = 1 << 16;
/// Bits of the table that finds a symbol; the rest is a search. A microcontroller has less room.
const FIND_BITS: u32 = if cfg!(feature = "std") { FREQUENCY_BITS } else { 8 };
/// Slots from one search to the next.
const FIND_STEP: usize = 1 << (FREQUENCY_BITS - FIND_BITS);

/// How often each byte occurs.
pub(crate) struct Frequencies {
    /// Frequencies of all bytes below, [`TOTAL`] at the end.
    below: [u16; 257],
    /// The byte at which the search for each slot begins.
    find: [u8; 1 << FIND_BITS],
}

impl Frequencies {
    /// Nothing occurs.
    pub(crate) const NONE: Self = Self { below: [0; 257], find: [0; 1 << FIND_BITS] };

    /// Reads [`Frequencies::NONE`] from the first bytes of a section, which are taken off: first
    /// and last byte that occurs, then the frequency of each of these and those between, seven
    /// bits a byte. In place: a copy is half of the stack that unpacking takes.
    pub(crate) fn read(&mut self, bytes: &mut &[u8]) -> Option<()> {
        let ([first, last], mut rest) = bytes.split_first_chunk().map(|(b, r)| (*b, r))?;
        let mut sum = 0;
        for byte in usize::from(first)..usize::from(last) + 1 {
            let (low, after) = rest.split_first()?;
            rest = after;
            let mut frequency = usize::from(*low & 0x7f);
            if *low >= 0x80 {
                let (high, after) = rest.split_first()?;
                rest = after;
                frequency |= usize::from(*high) << 7;
            }
            let slots = sum..sum + frequency;
            sum = slots.end;
            // The first slots of searches that begin in those of this byte.
            let found = slots.start.div_ceil(FIND_STEP)..slots.end.div_ceil(FIND_STEP);
            self.find.get_mut(found)?.fill(byte as u8);
            self.below[byte + 1] = sum as u16;
        }
        self.below[usize::from(last) + 1..].fill(sum as u16);
        *bytes = rest;
        (sum == TOTAL as usize).then_some(())
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
        let low = u32::from(self.below[usize::from(symbol)]);
        let high = u32::from(self.below[usize::from(symbol) + 1]);
        (symbol, (high - low) * (state >> FREQUENCY_BITS) + slot - low)
    }
}

/// Reads symbols.
pub(crate) struct SymbolReader<'p> {
    states: [u32; 2],
    words: core::slice::Iter<'p, [u8; 2]>,
    rest: &'p [u8],
}

impl<'p> SymbolReader<'p> {
    /// Of two states and the words behind them.
    pub(crate) fn new(packed: &'p [u8]) -> Option<Self> {
        let (states, packed) = packed.split_first_chunk::<8>()?;
        let [a, b, c, d, e, f, g, h] = *states;
        let states = [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])];
        let (words, rest) = packed.as_chunks::<2>();
        Some(Self { states, words: words.iter(), rest })
    }

    /// The next byte of a state.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    #[cfg_attr(target_os = "none", inline(never))] // A microcontroller has less room.
    pub(crate) fn byte(&mut self, state: usize, frequencies: &Frequencies) -> u8 {
        let (symbol, next) = frequencies.decode(self.states[state]);
        self.go_on(state, next);
        symbol
    }

    /// The next bit of a state, which is 0 `zeros` times of [`TOTAL`].
    #[cfg(feature = "planes")]
    #[inline(always)]
    pub(crate) fn bit(&mut self, state: usize, zeros: u32) -> bool {
        let (slot, high) = (self.states[state] & (TOTAL - 1), self.states[state] >> FREQUENCY_BITS);
        let bit = slot >= zeros;
        let next = match bit {
            true => (TOTAL - zeros) * high + slot - zeros,
            false => zeros * high + slot,
        };
        self.go_on(state, next);
        bit
    }

    #[inline(always)]
    fn go_on(&mut self, state: usize, next: u32) {
        self.states[state] = match next < LEAST_STATE {
            // Where words are missing the states do not end as they began.
            true => {
                next << 16 | u32::from(u16::from_le_bytes(*self.words.next().unwrap_or(&[0; 2])))
            }
            false => next,
        };
    }

    /// Whether the words end where the symbols do.
    pub(crate) fn is_at_end(&self) -> bool {
        self.states == [LEAST_STATE; 2] && self.words.len() == 0 && self.rest.is_empty()
    }
}
