//! Occupancy to fewer bytes.

use alloc::vec::Vec;

use super::bits::BitWriter;
use crate::packed::bits::Probability;
use crate::packed::cells::{
    BLOCK_BYTES, BLOCK_CONTEXTS, CELL_CONTEXTS, NUMBER_BYTES, Rows, block_context,
};

/// Block numbers, of a grid of `side`³ blocks that are numbered in order; else `None`.
pub(super) fn pack_blocks(coarse: &[u8], side: usize) -> Option<Vec<u8>> {
    let (numbers, rest) = coarse.as_chunks::<NUMBER_BYTES>();
    if !rest.is_empty() || Some(numbers.len()) != side.checked_pow(3) {
        return None;
    }
    let mut probabilities = [Probability::EVEN; BLOCK_CONTEXTS];
    let mut writer = BitWriter::new(u16::try_from(side).ok()?.to_le_bytes().to_vec());
    let mut last = 0u16;
    for (i, number) in numbers.iter().enumerate() {
        let number = u16::from_le_bytes(*number);
        if number != 0 {
            last = last.checked_add(1)?;
            if number != last {
                return None;
            }
        }
        let context = block_context(i, side, |j| numbers[j] != [0; NUMBER_BYTES]);
        writer.push(number != 0, &mut probabilities[context]);
    }
    Some(writer.finish())
}

/// The bits of blocks.
pub(super) fn pack_bits(fine: &[u8]) -> Option<Vec<u8>> {
    let (blocks, rest) = fine.as_chunks::<BLOCK_BYTES>();
    if !rest.is_empty() {
        return None;
    }
    let mut probabilities = [Probability::EVEN; CELL_CONTEXTS];
    let mut writer = BitWriter::new(Vec::new());
    for block in blocks {
        for (row, bits) in block.iter().enumerate() {
            let rows = Rows::of(block, row);
            for x in 0..8 {
                let before = bits & ((1 << x) - 1);
                writer.push(bits >> x & 1 == 1, &mut probabilities[rows.context(before, x)]);
            }
        }
    }
    Some(writer.finish())
}
