//! Symbols of the static coder, as SPEC.md has them.

/// Symbols of encodings 1 and 6, and what is before them.
pub(super) struct Symbols<'p> {
    payload: &'p [u8],
    pub(super) at: usize,
    pub(super) states: [u32; 2],
}

impl<'p> Symbols<'p> {
    pub(super) const fn new(payload: &'p [u8], at: usize) -> Self {
        Self { payload, at, states: [0; 2] }
    }

    /// The next number of so many bytes.
    pub(super) fn number(&mut self, size: usize) -> u32 {
        let bytes = &self.payload[self.at..][..size];
        self.at += size;
        bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte))
    }

    /// `first`, `last` and `frequencies`.
    pub(super) fn frequencies(&mut self) -> [u32; 256] {
        let mut frequencies = [0; 256];
        let [first, last] = [0; 2].map(|_| self.number(1) as usize);
        for frequency in &mut frequencies[first..=last] {
            let low = self.number(1);
            *frequency = low % 128 + if low >= 0x80 { self.number(1) << 7 } else { 0 };
        }
        assert_eq!(frequencies.iter().sum::<u32>(), 4096);
        frequencies
    }

    pub(super) fn begin(&mut self) {
        self.states = [0; 2].map(|_| self.number(4));
    }

    /// The next symbol, of which there are so many.
    pub(super) fn next(&mut self, state: usize, frequencies: &[u32]) -> usize {
        let x = self.states[state];
        let (s, mut low, mut symbol) = (x % 4096, 0, 0);
        while s >= low + frequencies[symbol] {
            low += frequencies[symbol];
            symbol += 1;
        }
        let x = frequencies[symbol] * (x >> 12) + s - low;
        self.states[state] = if x < 1 << 16 { x * 65536 + self.number(2) } else { x };
        symbol
    }
}
