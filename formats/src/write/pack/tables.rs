//! Tables of bytes to fewer.

use alloc::vec;
use alloc::vec::Vec;

use super::ans::{self, Frequencies};
use crate::packed::tables::CHUNK;

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
    let frequencies = Frequencies::of(counts);
    let mut packed = vec![block];
    frequencies.write(&mut packed);
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
        let held = blocks().filter(|block| !is_empty(block));
        let symbols = held.flat_map(|block| {
            let numbered = block.iter().enumerate();
            numbered.map(|(i, value)| frequencies.symbol(*value, i % 2))
        });
        ans::write(symbols, &mut packed);
        let length = u16::try_from(packed.len() - begun).ok()?;
        packed[directory + 2 * number..][..2].copy_from_slice(&length.to_le_bytes());
    }
    Some(packed)
}
