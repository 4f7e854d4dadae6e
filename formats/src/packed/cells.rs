//! Occupancy, packed: bits whose probability follows from the bits beside them.

use super::bits::{BitReader, Probability};

/// Bytes of a block's number.
pub(crate) const NUMBER_BYTES: usize = 2;
/// Bytes of a block's bits.
pub(crate) const BLOCK_BYTES: usize = 64;
/// Situations that a block may be in.
pub(crate) const BLOCK_CONTEXTS: usize = 64;
/// Situations that a cell may be in.
pub(crate) const CELL_CONTEXTS: usize = 512;

/// The blocks that tell of one: along which axes each lies before it, a bit an axis.
const BEFORE: [u8; 6] = [1, 2, 4, 3, 5, 6];

/// Which of the blocks before block `i`, that touch it, hold something. `holds` tells of a block
/// before it; there are `side` of them along an axis.
pub(crate) fn block_context(i: usize, side: usize, holds: impl Fn(usize) -> bool) -> usize {
    let [x, y, z] = [i % side, i / side % side, i / side / side];
    let inside = usize::from(x > 0) | usize::from(y > 0) << 1 | usize::from(z > 0) << 2;
    let mut context = 0;
    for (bit, axes) in BEFORE.iter().enumerate() {
        let axes = usize::from(*axes);
        let back = (axes & 1) + side * ((axes >> 1 & 1) + side * (axes >> 2));
        let beside = axes & !inside == 0 && holds(i - back);
        context |= usize::from(beside) << bit;
    }
    context
}

/// The rows of cells of a block that a row's cells are told by.
#[derive(Clone, Copy)]
pub(crate) struct Rows([u16; 4]);

impl Rows {
    /// Of row `y + 8 z` of a block: the rows at y - 1, z - 1, both, and y + 1 with z - 1.
    #[inline(always)]
    pub(crate) fn of(block: &[u8; BLOCK_BYTES], row: usize) -> Self {
        let [y, z] = [row % 8, row / 8];
        let at = |there: bool, row: usize| if there { u16::from(block[row]) } else { 0 };
        Self([
            at(y > 0, row.wrapping_sub(1)) << 1,
            at(z > 0, row.wrapping_sub(8)) << 1,
            at(y > 0 && z > 0, row.wrapping_sub(9)),
            at(y < 7 && z > 0, row.wrapping_sub(7)),
        ])
    }

    /// The situation of cell `x`, `bits` being those of its row before it.
    #[inline(always)]
    pub(crate) const fn context(self, bits: u8, x: u32) -> usize {
        let [below, behind, both, above] = self.0;
        let before = (bits as u16) << 1 >> x & 1;
        let context = (below >> x & 7) | (behind >> x & 7) << 3 | (both >> x & 1) << 6;
        (context | (above >> x & 1) << 7 | before << 8) as usize
    }
}

/// Numbers the blocks that hold something, in order from 1; the others get 0.
pub(super) fn unpack_blocks(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (side, packed) = packed.split_first_chunk()?;
    let side = u16::from_le_bytes(*side);
    let (numbers, rest) = out.as_chunks_mut::<NUMBER_BYTES>();
    if side == 0 || !rest.is_empty() || numbers.len() as u64 != u64::from(side).pow(3) {
        return None;
    }
    let mut probabilities = [Probability::EVEN; BLOCK_CONTEXTS];
    let mut reader = BitReader::new(packed)?;
    let mut last = 0u16;
    for i in 0..numbers.len() {
        let context = block_context(i, side.into(), |j| numbers[j] != [0; NUMBER_BYTES]);
        numbers[i] = match reader.next(&mut probabilities[context]) {
            true => {
                last = last.checked_add(1)?;
                last.to_le_bytes()
            }
            false => [0; NUMBER_BYTES],
        };
    }
    reader.is_at_end().then_some(())
}

/// The bits of all blocks.
pub(super) fn unpack_bits(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (blocks, rest) = out.as_chunks_mut::<BLOCK_BYTES>();
    if !rest.is_empty() {
        return None;
    }
    let mut probabilities = [Probability::EVEN; CELL_CONTEXTS];
    let mut reader = BitReader::new(packed)?;
    for block in blocks {
        for row in 0..BLOCK_BYTES {
            let (rows, mut bits) = (Rows::of(block, row), 0);
            for x in 0..8 {
                let bit = reader.next(&mut probabilities[rows.context(bits, x)]);
                bits |= u8::from(bit) << x;
            }
            block[row] = bits;
        }
    }
    reader.is_at_end().then_some(())
}
