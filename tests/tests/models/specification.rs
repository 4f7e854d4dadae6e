//! `SPEC.md` is enough to read a file.

use std::fs;
use std::path::PathBuf;

use pocketnerf_core::AnyField;
use pocketnerf_core::encoding::hash_grid::HASH_PRIMES;
use pocketnerf_tests::checksums::{crc32, number};
use pocketnerf_tests::tiny::Tiny;

use crate::compare::F16_ROUNDING;

/// Reads the f16 golden as a stranger would: with SPEC.md and nothing else.
#[test]
fn by_hand_from_the_specification() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden/hash-grid-f16.pnerf");
    let file = fs::read(path).unwrap();
    let at = |offset: usize, size: usize| number(&file, offset, size).unwrap() as usize;

    // Header.
    assert_eq!(file[..8], [0xab, 0x50, 0x4e, 0x52, 0x46, 0x0d, 0x0a, 0x1a]);
    assert_eq!((at(8, 2), at(10, 2)), (1, 0));
    assert_eq!(at(16, 8), file.len());
    let table_end = 32 + 48 * at(12, 4);
    let mut head = file[..table_end].to_vec();
    head[24..28].fill(0);
    assert_eq!(at(24, 4), crc32(&head) as usize);

    // The payload of a section, by kind and index.
    let section = |kind: usize, index: usize| {
        let entry = (32..table_end)
            .step_by(48)
            .find(|entry| (at(*entry, 4), at(entry + 4, 4)) == (kind, index))
            .unwrap();
        let (offset, length) = (at(entry + 16, 8), at(entry + 24, 8));
        assert_eq!(offset % 64, 0);
        let payload = &file[offset..offset + length];
        assert_eq!(at(entry + 40, 4), crc32(payload) as usize);
        payload
    };
    // FIELD: kind, levels, features, log2 of the table, base resolution, growth.
    let field = section(4, 0);
    assert_eq!(field[..5], [0, 2, 2, 8, 4]);
    assert_eq!(field[5..9], 2.0f32.to_le_bytes());

    // TENSORS: ten entries. The second is level 1: name, index, f16, 256 as a
    // varint, 2, the scale, row-major, section GRID 1.
    let directory = section(8, 0);
    assert_eq!(directory[0], 10);
    let first = [0, 0, 1, 0xd8, 0x01, 2, 0xf0, 0, 16, 0];
    let second = [0, 1, 1, 0x80, 0x02, 2, 0xf0, 0, 16, 1];
    assert_eq!(directory[1..11], first);
    assert_eq!(directory[11..21], second);
    let scale = 2f64.powi((second[6] as i8).into());

    // Level 1: 4 * 2 - 1 = 7 cells, 8 corners, 5 blocks an axis; 8 * 5^3 > 2^8: hashed.
    // Corner (5, 2, 7): block (2, 1, 3), low bits (1, 0, 1).
    let hash = 2 ^ HASH_PRIMES[1] ^ HASH_PRIMES[2].wrapping_mul(3);
    let entry = (8 * (hash % 32) + 1 + 4) as usize;
    let table = section(16, 1);
    assert_eq!(table.len(), 256 * 2 * 2);
    let bits = number(table, (entry * 2 + 1) * 2, 2).unwrap();
    let (sign, exponent, mantissa) = (bits >> 15, bits >> 10 & 31, bits & 1023);
    assert!((1..31).contains(&exponent));
    let magnitude = (1.0 + mantissa as f64 / 1024.0) * 2f64.powi(exponent as i32 - 15);
    let value = if sign == 1 { -magnitude } else { magnitude } * scale;

    let tiny = Tiny::new();
    let AnyField::HashGrid(expected) = tiny.hash_grid().field else { unreachable!() };
    let expected = f64::from(expected.grid.levels[1].get(entry * 2 + 1));
    assert!((value - expected).abs() <= f64::from(F16_ROUNDING), "{value} {expected}");

    // Cell (3, 2, 1) lies in block 0, byte y + 8 z, bit x.
    let number_of_block = number(section(18, 0), 0, 2).unwrap() as usize;
    let byte = section(19, 0)[(number_of_block - 1) * 64 + 2 + 8];
    let occupancy = tiny.hash_grid().occupancy.unwrap();
    assert_eq!(byte >> 3 & 1 == 1, occupancy.cell(3, 2, 1));
}
