//! Tables of an encoding: rounded, and what they take when they are packed.

use crate::field::rounding::DEAD_ZONE;
use pocketnerf_core::encoding::Planes;
use pocketnerf_core::{AnyField, Model, TensorView};

/// Entries that lie together.
const BLOCK: usize = 8;
/// Values that are packed together.
const CHUNK: usize = 8192;

/// The tables of a hash grid, coarse to fine, or those of planes, each plane before its line, as
/// the file has them; none for other kinds of field.
pub(super) fn all<'a>(model: &Model<'a>) -> Vec<TensorView<'a>> {
    match &model.field {
        AnyField::HashGrid(field) => {
            field.grid.levels[..field.grid.config.n_levels as usize].to_vec()
        }
        AnyField::Planes(field) => {
            let pairs = &field.planes.pairs[..Planes::n_pairs(field.planes.n_components)];
            pairs.iter().flat_map(|pair| [pair.plane, pair.line]).collect()
        }
        _ => Vec::new(),
    }
}

/// Values of eight bits, each the nearest multiple of `step` that eight bits hold, or 0 in the
/// [dead zone](DEAD_ZONE).
pub(super) fn rounded(table: &[u8], step: u8) -> Vec<u8> {
    let (step, most) = (i16::from(step), i16::from(127 / step));
    let round = |value: &u8| {
        let value = i16::from(value.cast_signed());
        if step > 1 && f32::from(value.abs()) < DEAD_ZONE * f32::from(step) {
            return 0;
        }
        // Halves away from zero, both ways alike.
        let n = (2 * value.abs() + step) / (2 * step);
        (value.signum() * n.min(most) * step) as u8
    };
    table.iter().map(round).collect()
}

/// Bytes that a packed table takes, about: the entropy of its values, where not a whole block is 0.
pub(super) fn rate(table: &[u8], features: usize) -> f64 {
    let mut counts = [0u64; 256];
    let blocks = table.chunks(BLOCK * features.max(1));
    for block in blocks.filter(|block| block.iter().any(|value| *value != 0)) {
        block.iter().for_each(|value| counts[usize::from(*value)] += 1);
    }
    let all = counts.iter().sum::<u64>().max(1) as f64;
    let used = counts.iter().filter(|count| **count > 0);
    let bits: f64 = used.clone().map(|n| *n as f64 * (all / *n as f64).log2()).sum();
    // Frequencies, and what every chunk has beside them, unless it is empty as a whole.
    let chunks = table.chunks(CHUNK).map(|chunk| match chunk.iter().all(|value| *value == 0) {
        true => 2.0,
        false => 43.0,
    });
    bits / 8.0 + 1.5 * used.count() as f64 + chunks.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_by_hand() {
        let values = [0, 1, 2, 5, 126, 127, -1, -2, -5, -127i8].map(i8::cast_unsigned);
        let of = |step| rounded(&values, step).into_iter().map(u8::cast_signed).collect::<Vec<_>>();
        assert_eq!(of(1), [0, 1, 2, 5, 126, 127, -1, -2, -5, -127]);
        // Half a step is in the dead zone, three quarters are not.
        assert_eq!(of(4), [0, 0, 0, 4, 124, 124, 0, 0, -4, -124]);
        assert_eq!(of(3), [0, 0, 3, 6, 126, 126, 0, -3, -6, -126]);
        assert_eq!(of(64), [0, 0, 0, 0, 64, 64, 0, 0, 0, -64]);
        assert_eq!(of(255), [0; 10]);
    }

    #[test]
    fn entropy_by_hand() {
        // Half zeros, half ones, no empty block: a bit a value.
        let table: Vec<u8> = (0..8192u32).map(|i| (i % 2) as u8).collect();
        assert!((rate(&table, 4) - (1024.0 + 3.0 + 43.0)).abs() < 1e-9);
        // Empty chunks take nothing but their length, empty blocks nothing but their flags.
        assert_eq!(rate(&[0; 8192], 4), 2.0);
        let mut table = vec![0; 8192];
        table[..32].fill(1);
        assert_eq!(rate(&table, 4), 1.5 + 43.0);
    }
}
