//! Range variants of asymmetric numeral systems: the encoder.

use alloc::vec::Vec;

use crate::packed::ans::{FREQUENCY_BITS, LEAST_STATE, TOTAL};

/// A symbol: which state it is coded with, the sum of the frequencies below its own, and that.
#[derive(Clone, Copy)]
pub(super) struct Symbol {
    pub(super) state: usize,
    pub(super) below: u32,
    pub(super) frequency: u32,
}

/// How often each byte occurs, in parts of [`TOTAL`].
pub(super) struct Frequencies {
    frequencies: [u32; 256],
    below: [u32; 256],
}

impl Frequencies {
    /// About in proportion to how often they are counted.
    pub(super) fn of(mut counts: [u64; 256]) -> Self {
        // Any frequencies will do where nothing is coded.
        counts[0] += u64::from(counts == [0; 256]);
        let frequencies = frequencies(&counts);
        let mut below = [0; 256];
        let mut sum = 0;
        for (below, frequency) in below.iter_mut().zip(&frequencies) {
            *below = sum;
            sum += frequency;
        }
        Self { frequencies, below }
    }

    /// A byte that has been counted.
    pub(super) fn symbol(&self, byte: u8, state: usize) -> Symbol {
        let byte = usize::from(byte);
        Symbol { state, below: self.below[byte], frequency: self.frequencies[byte] }
    }

    pub(super) fn write(&self, packed: &mut Vec<u8>) {
        let used = || (0..256).filter(|i| self.frequencies[*i] > 0);
        let (first, last) = (used().next().unwrap_or(0), used().next_back().unwrap_or(0));
        packed.extend([first as u8, last as u8]);
        for frequency in &self.frequencies[first..=last] {
            let low = (frequency & 0x7f) as u8;
            match frequency >> 7 {
                0 => packed.push(low),
                high => packed.extend([low | 0x80, high as u8]),
            }
        }
    }
}

/// States, then words in the order in which they are read.
pub(super) fn write(symbols: impl DoubleEndedIterator<Item = Symbol>, packed: &mut Vec<u8>) {
    let mut states = [LEAST_STATE; 2];
    let mut words = Vec::new();
    for Symbol { state, below, frequency } in symbols.rev() {
        let state = &mut states[state];
        if u64::from(*state) >= u64::from(frequency) << (32 - FREQUENCY_BITS) {
            words.push(*state as u16);
            *state >>= 16;
        }
        *state = (*state / frequency) << FREQUENCY_BITS | (*state % frequency + below);
    }
    packed.extend(states.iter().flat_map(|state| state.to_le_bytes()));
    packed.extend(words.iter().rev().flat_map(|word| word.to_le_bytes()));
}

/// Frequencies that sum up to [`TOTAL`], none 0 where the count is not: each in proportion, and
/// the rest where it saves or costs least.
fn frequencies(counts: &[u64; 256]) -> [u32; 256] {
    let all: u64 = counts.iter().sum();
    let share = |count: u64| (count * u64::from(TOTAL) / all) as u32;
    let mut frequencies = counts.map(|count| share(count).max(u32::from(count > 0)));
    loop {
        let sum: u32 = frequencies.iter().sum();
        let ratio = |i: usize| counts[i] as f64 / f64::from(frequencies[i].max(1));
        let used = (0..256).filter(|i| counts[*i] > 0);
        if sum < TOTAL {
            let most = used.max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)));
            most.into_iter().for_each(|i| frequencies[i] += 1);
        } else if sum > TOTAL {
            let above = used.filter(|i| frequencies[*i] > 1);
            let least = above.min_by(|a, b| ratio(*a).total_cmp(&ratio(*b)));
            least.into_iter().for_each(|i| frequencies[i] -= 1);
        } else {
            return frequencies;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_by_hand() {
        let mut counts = [0; 256];
        (counts[3], counts[200]) = (3, 1);
        let found = frequencies(&counts);
        assert_eq!((found[3], found[200], found.iter().sum::<u32>()), (3072, 1024, TOTAL));
        // What is rare has one of the slots, whatever its share.
        (counts[3], counts[7]) = (1_000_000, 1);
        let found = frequencies(&counts);
        assert_eq!((found[3], found[7], found[200]), (4094, 1, 1));
        // All alike.
        assert_eq!(frequencies(&[5; 256]), [16; 256]);
    }
}
