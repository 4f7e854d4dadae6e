//! Planes to fewer bytes.

use alloc::vec::Vec;

use pocketnerf_core::encoding::planes::FEATURES;
use pocketnerf_core::{AnyField, DType};

use super::ans::{self, Frequencies, Symbol};
use crate::ModelFile;
use crate::packed::MOST_RATIO;
use crate::packed::ans::TOTAL;
use crate::packed::planes::{AS_EXPECTED, Around, CLASSES, CONTEXTS, Entry, Expected, holds};

/// Entries in a row, where a table is a plane of bytes.
pub(super) fn row(file: &ModelFile<'_>, table: usize) -> Option<u16> {
    let AnyField::Planes(field) = &file.model.field else { return None };
    let is_plane = table.is_multiple_of(2) && field.planes.pairs[0].plane.dtype() == DType::I8;
    u16::try_from(field.planes.resolution).ok().filter(|_| is_plane)
}

/// An entry that holds something, with what is known before.
struct Held {
    values: Entry,
    expected: Expected,
}

/// A plane with rows of so many entries; `None` where it has none, or holds next to nothing.
pub(super) fn pack(values: &[u8], row: u16) -> Option<Vec<u8>> {
    let (step, steps) = in_steps(values);
    let (entries, rest) = steps.as_chunks::<FEATURES>();
    if row == 0 || !rest.is_empty() {
        return None;
    }
    // Of each entry the neighbours that hold something, and itself, if it does.
    let walked = (0..entries.len()).map(|i| {
        let around = Around::of(&entries[..i], row.into());
        let values = entries[i];
        let held = holds(&values).then(|| Held { values, expected: around.expected() });
        (around.context(), held)
    });
    let walked: Vec<(usize, Option<Held>)> = walked.collect();
    let held = || walked.iter().filter_map(|(_, held)| held.as_ref());
    let limits = limits(held());
    let mut counts = [[0; 256]; CLASSES];
    for held in held() {
        for v in 0..FEATURES {
            let (class, code) = held.code(v, limits);
            counts[class][usize::from(code)] += 1;
        }
    }
    let frequencies = counts.map(Frequencies::of);
    let zeros = zeros(&walked);
    let mut packed = Vec::from(row.to_le_bytes());
    packed.push(step);
    packed.extend(limits);
    packed.extend(zeros.iter().flat_map(|zeros| (*zeros as u16).to_le_bytes()));
    frequencies.iter().for_each(|frequencies| frequencies.write(&mut packed));
    let symbols = walked.iter().flat_map(|(context, held)| {
        let zeros = zeros[*context];
        let flag = match held {
            None => Symbol { state: 0, below: 0, frequency: zeros },
            Some(_) => Symbol { state: 0, below: zeros, frequency: TOTAL - zeros },
        };
        let values = held.iter().flat_map(|held| {
            (0..FEATURES).map(|v| {
                let (class, code) = held.code(v, limits);
                frequencies[class].symbol(code, v % 2)
            })
        });
        core::iter::once(flag).chain(values)
    });
    ans::write(symbols, &mut packed);
    let is_refused = values.len() as u64 > MOST_RATIO * packed.len() as u64;
    (!is_refused).then_some(packed)
}

/// Bytes that a plane takes when it is packed, about: rows of so many entries, whose values are
/// bytes.
#[must_use]
pub fn packed_plane_len(values: &[u8], row: u16) -> usize {
    pack(values, row).map_or(values.len().div_ceil(MOST_RATIO as usize), |packed| packed.len())
}

impl Held {
    /// The class of a value and how it differs from what is expected.
    fn code(&self, v: usize, limits: [u8; CLASSES - 2]) -> (usize, u8) {
        let expected = self.expected.values[v].cast_unsigned();
        let code = self.values[v].wrapping_sub(expected).wrapping_add(AS_EXPECTED);
        (self.expected.class(v, limits), code)
    }
}

/// The largest step that all values are whole multiples of, and these multiples.
fn in_steps(values: &[u8]) -> (u8, Vec<u8>) {
    const fn divisor(mut a: u8, mut b: u8) -> u8 {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    }
    let magnitudes = values.iter().map(|value| value.cast_signed().unsigned_abs());
    let step = magnitudes.fold(0, divisor).max(1);
    let multiple = |value: &u8| (i16::from(value.cast_signed()) / i16::from(step)) as u8;
    (step, values.iter().map(multiple).collect())
}

/// Doubts that a third and two thirds of all values do not exceed.
fn limits<'h>(held: impl Iterator<Item = &'h Held>) -> [u8; CLASSES - 2] {
    let mut counts = [0u64; 256];
    for doubt in held.filter_map(|held| held.expected.doubts).flatten() {
        counts[usize::from(doubt).min(255)] += 1;
    }
    let all: u64 = counts.iter().sum();
    core::array::from_fn(|i| {
        let part = all * (i as u64 + 1) / (CLASSES as u64 - 1);
        let mut sum = 0;
        let reached = counts.iter().position(|count| {
            sum += count;
            sum >= part
        });
        reached.unwrap_or(0) as u8
    })
}

/// How often an entry with such neighbours holds nothing, in parts of [`TOTAL`]; never not at
/// all, nor always.
fn zeros(walked: &[(usize, Option<Held>)]) -> [u32; CONTEXTS] {
    let mut counts = [[1u64; 2]; CONTEXTS];
    for (context, held) in walked {
        counts[*context][usize::from(held.is_some())] += 1;
    }
    counts.map(|[empty, held]| {
        let share = empty * u64::from(TOTAL) / (empty + held);
        (share as u32).clamp(1, TOTAL - 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::planes::unpack;

    /// A plane of smooth values with a hole, of noise, and of the largest differences.
    fn plane(kind: usize, row: usize, step: i8) -> Vec<u8> {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let most = 127 / step;
        let value = |i: usize, random: u8| {
            let (x, y) = ((i / FEATURES % row) as f32, (i / FEATURES / row) as f32);
            let multiple = match kind {
                0 => ((0.1 * x).sin() * (0.07 * y + i as f32 % 8.0).cos() * f32::from(most)) as i8,
                1 => random.cast_signed().max(-127) % most.max(2),
                _ => [most, 1 - most, 0][usize::from(random % 3)],
            };
            let is_hole = (x - 7.0).hypot(y - 9.0) < 4.0;
            if is_hole { 0 } else { (multiple * step).cast_unsigned() }
        };
        (0..row * row * FEATURES).map(|i| value(i, random())).collect()
    }

    #[test]
    fn what_is_packed_comes_back() {
        for (kind, row, step) in [(0, 40, 1), (0, 33, 16), (1, 20, 1), (1, 2, 3), (2, 21, 127)] {
            let values = plane(kind, row, step);
            let packed = pack(&values, row as u16).unwrap();
            assert_eq!(packed[..2], (row as u16).to_le_bytes());
            // Whatever was there before.
            for filled in [0, 0xff] {
                let mut out = alloc::vec![filled; values.len()];
                unpack(&packed, &mut out).unwrap();
                assert!(out == values, "{kind} {row} {step}");
            }
            assert_eq!(unpack(&packed, &mut alloc::vec![0; values.len() - 1]), None);
            assert_eq!(unpack(&packed, &mut alloc::vec![0; values.len() - 8]), None);
            assert_eq!(unpack(&packed[..packed.len() - 2], &mut alloc::vec![0; 64]), None);
        }
        // -128 is no multiple of anything that 127 is one of.
        let values: Vec<u8> = (0..64 * 8).map(|i| [128, 127, 0, 64][i % 4]).collect();
        let mut out = alloc::vec![0; values.len()];
        unpack(&pack(&values, 8).unwrap(), &mut out).unwrap();
        assert!(out == values);
    }

    #[test]
    fn what_follows_from_its_neighbours_takes_few_bytes() {
        let smooth = plane(0, 100, 1);
        let table = super::super::tables::pack(&smooth, 64).unwrap();
        let packed = pack(&smooth, 100).unwrap();
        assert!(2 * packed.len() < table.len(), "{} {}", packed.len(), table.len());
    }

    #[test]
    fn other_shapes_are_not_packed() {
        assert!(pack(&[1; 80], 0).is_none());
        assert!(pack(&[1; 81], 2).is_none());
        // Nothing: so few bytes cannot stand for so many.
        assert!(pack(&alloc::vec![0; 2_000_000], 500).is_none());
    }

    /// What is said of the step is not believed.
    #[test]
    fn values_of_more_than_eight_bits_are_refused() {
        let values = plane(2, 21, 42);
        let mut packed = pack(&values, 21).unwrap();
        assert_eq!(packed[2], 42);
        packed[2] = 43;
        assert_eq!(unpack(&packed, &mut alloc::vec![0; values.len()]), None);
    }
}
