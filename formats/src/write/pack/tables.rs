//! Tables of bytes to fewer.

use alloc::vec;
use alloc::vec::Vec;

use crate::packed::tables::{CHUNK, FREQUENCY_BITS, LEAST_STATE, TOTAL};

/// Values, in blocks of `block` of them of which some may be all 0. `None` where there is nothing
/// to be packed.
pub(super) fn pack(values: &[u8], block: u8) -> Option<Vec<u8>> {
    if values.is_empty() || block == 0 {
        return None;
    }
    let block_bytes = usize::from(block);
    let is_empty = |block: &[u8]| block.iter().all(|value| *value == 0);
    let mut counts = [0u64; 256];
    for block in values.chunks(CHUNK).flat_map(|chunk| chunk.chunks(block_bytes)) {
        if !is_empty(block) {
            block.iter().for_each(|value| counts[usize::from(*value)] += 1);
        }
    }
    // Any frequencies will do where nothing is coded.
    counts[0] += u64::from(counts == [0; 256]);
    let frequencies = frequencies(&counts);
    let mut packed = vec![block];
    write_frequencies(&frequencies, &mut packed);
    let mut below = [0; 256];
    let mut sum = 0;
    for (below, frequency) in below.iter_mut().zip(&frequencies) {
        *below = sum;
        sum += frequency;
    }
    let directory = packed.len();
    packed.resize(directory + 2 * values.len().div_ceil(CHUNK), 0);
    let chunks = values.chunks(CHUNK).enumerate();
    // One that is empty as a whole takes no bytes.
    for (number, chunk) in chunks.filter(|(_, chunk)| !is_empty(chunk)) {
        let begun = packed.len();
        let blocks = || chunk.chunks(block_bytes);
        let some_empty = blocks().any(is_empty);
        packed.push(some_empty.into());
        if some_empty {
            let flags = packed.len();
            packed.resize(flags + blocks().len().div_ceil(8), 0);
            for (i, _) in blocks().enumerate().filter(|(_, block)| is_empty(block)) {
                packed[flags + i / 8] |= 1 << (i % 8);
            }
        }
        pack_chunk(blocks().filter(|block| !is_empty(block)), (&frequencies, &below), &mut packed);
        let length = u16::try_from(packed.len() - begun).ok()?;
        packed[directory + 2 * number..][..2].copy_from_slice(&length.to_le_bytes());
    }
    Some(packed)
}

/// States, then words in the order in which they are read.
fn pack_chunk<'v>(
    blocks: impl DoubleEndedIterator<Item = &'v [u8]>,
    (frequencies, below): (&[u32; 256], &[u32; 256]),
    packed: &mut Vec<u8>,
) {
    let mut states = [LEAST_STATE; 2];
    let mut words = Vec::new();
    for block in blocks.rev() {
        for (i, value) in block.iter().enumerate().rev() {
            let state = &mut states[i % 2];
            let frequency = frequencies[usize::from(*value)];
            if u64::from(*state) >= u64::from(frequency) << (32 - FREQUENCY_BITS) {
                words.push(*state as u16);
                *state >>= 16;
            }
            let slot = *state % frequency + below[usize::from(*value)];
            *state = (*state / frequency) << FREQUENCY_BITS | slot;
        }
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

fn write_frequencies(frequencies: &[u32; 256], packed: &mut Vec<u8>) {
    let used = || (0..256).filter(|i| frequencies[*i] > 0);
    let (first, last) = (used().next().unwrap_or(0), used().next_back().unwrap_or(0));
    packed.extend([first as u8, last as u8]);
    for frequency in &frequencies[first..=last] {
        let low = (frequency & 0x7f) as u8;
        match frequency >> 7 {
            0 => packed.push(low),
            high => packed.extend([low | 0x80, high as u8]),
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
