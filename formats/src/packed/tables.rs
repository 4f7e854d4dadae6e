//! Tables of bytes, packed: one frequency table a section, in chunks that stand alone.

use super::ans::{Frequencies, SymbolReader};

/// Values of a chunk.
pub(crate) const CHUNK: usize = 1 << 13;

/// The values of all chunks.
pub(super) fn unpack(mut packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (block, rest) = packed.split_first()?;
    packed = rest;
    let block = usize::from(*block);
    if block == 0 {
        return None;
    }
    let mut frequencies = Frequencies::NONE;
    frequencies.read(&mut packed)?;
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
    let mut symbols = SymbolReader::new(packed)?;
    for (i, values) in out.chunks_mut(block).enumerate() {
        if empty.get(i / 8).is_some_and(|flags| flags >> (i % 8) & 1 == 1) {
            values.fill(0);
            continue;
        }
        let (pairs, odd) = values.as_chunks_mut::<2>();
        for pair in pairs {
            *pair = [symbols.byte(0, frequencies), symbols.byte(1, frequencies)];
        }
        for value in odd {
            *value = symbols.byte(0, frequencies);
        }
    }
    symbols.is_at_end().then_some(())
}
