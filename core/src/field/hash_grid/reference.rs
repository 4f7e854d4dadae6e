//! The hash grid, corner by corner, from the text of [`crate::encoding::hash_grid`].

use crate::encoding::hash_grid::GridIndex;
use crate::encoding::hash_grid::{HASH_PRIMES, HashGrid, HashGridConfig};
use crate::field::{Features, HashGridField, ReferenceField};
use crate::reference::field::decode;
use crate::reference::network::{MAX_WIDTH, Values};

impl ReferenceField for HashGridField<'_> {
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        decode(&self.decoder, &encode(&self.grid, u), direction)
    }
}

/// Encodes unit point `u`: F features of level 0, then of level 1, ...
fn encode(grid: &HashGrid<'_>, u: [f32; 3]) -> Values {
    let n_features = grid.config.n_features_per_level as usize;
    let mut out = [0.0; MAX_WIDTH];
    for level in 0..grid.config.n_levels as usize {
        let table = &grid.levels[level];
        let shape = LevelShape::new(&grid.config, level);
        let position = u.map(|v| f64::from(v).clamp(0.0, 1.0) * shape.scale + shape.shift);
        let cell = position.map(|v| v as u32);
        for corner in 0..8u32 {
            let mut weight = 1.0;
            let mut c = cell;
            for axis in 0..3 {
                let fraction = position[axis] - f64::from(cell[axis]);
                let far_side = corner >> axis & 1;
                c[axis] += far_side;
                weight *= if far_side == 1 { fraction } else { 1.0 - fraction };
            }
            let entry = shape.entry(c);
            for f in 0..n_features {
                out[level * n_features + f] +=
                    weight * f64::from(table.get(entry * n_features + f));
            }
        }
    }
    out
}

/// How a level is laid out, worked out from the configuration.
struct LevelShape {
    /// Cells along a unit length: an f32, as renderers have it.
    scale: f64,
    /// Where u = 0 lies, in cells.
    shift: f64,
    numbering: Numbering,
}

enum Numbering {
    /// Every block has a place of its own; so many stand along an axis.
    Dense(u32),
    /// Blocks share this many places, a power of two.
    Hashed(u32),
    /// Corner by corner, so many along an axis, going around so many entries.
    DenseCorners(u32, u32),
    /// Corners share this many entries, a power of two.
    HashedCorners(u32),
}

impl LevelShape {
    fn new(config: &HashGridConfig, level: usize) -> Self {
        if let GridIndex::Corners(corners) = config.index {
            let crate::encoding::CornerLevel { scale, side, entries } = corners.levels[level];
            let numbering = match side {
                0 => Numbering::HashedCorners(entries),
                _ => Numbering::DenseCorners(side, entries),
            };
            return Self { scale: scale.into(), shift: corners.shift.into(), numbering };
        }
        let growth = f64::from(config.per_level_scale);
        let side = (0..level).fold(f64::from(config.base_resolution), |side, _| side * growth);
        let scale = f64::from((side - 1.0) as f32);
        // Corners 0 ..= ceil(scale); a block holds two along an axis.
        let mut corners = scale as u64 + 1;
        if scale > (corners - 1) as f64 {
            corners += 1;
        }
        let blocks = corners / 2 + 1;
        let numbering = if 8 * blocks * blocks * blocks <= 1 << config.log2_hashmap_size {
            Numbering::Dense(blocks as u32)
        } else {
            Numbering::Hashed(1 << (config.log2_hashmap_size - 3))
        };
        Self { scale, shift: 0.5, numbering }
    }

    /// The number of the entry of corner `c`.
    fn entry(&self, c: [u32; 3]) -> usize {
        let hash = |c: [u32; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| c[axis].wrapping_mul(HASH_PRIMES[axis]));
            x ^ y ^ z
        };
        let [x, y, z] = c.map(|v| v / 2);
        let block = match self.numbering {
            Numbering::Dense(n) => x + n * y + n * n * z,
            Numbering::Hashed(places) => hash([x, y, z]) % places,
            Numbering::DenseCorners(n, entries) => {
                return ((c[0] + n * (c[1] + n * c[2])) % entries) as usize;
            }
            Numbering::HashedCorners(entries) => return (hash(c) % entries) as usize,
        };
        (8 * block + c[0] % 2 + 2 * (c[1] % 2) + 4 * (c[2] % 2)) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TensorView;
    use crate::encoding::MAX_LEVELS;
    use crate::reference::testing::tensor;

    fn config(n_levels: u32, n_features_per_level: u32) -> HashGridConfig {
        HashGridConfig {
            n_levels,
            n_features_per_level,
            log2_hashmap_size: 6,
            base_resolution: 2,
            per_level_scale: 2.0,
            index: GridIndex::Blocked,
        }
    }

    #[test]
    fn trilinear_by_hand() {
        // Base resolution 2: one cell a unit length, u lies at u + 0.5, so corner (1, 1, 1)
        // is u = 1/2. Two blocks along an axis: 8 blocks, 64 entries.
        // (0, 0, 0) is entry 0, (1, 0, 0) entry 1, (0, 1, 0) entry 2, (1, 1, 1) entry 7;
        // (2, 1, 1) is block (1, 0, 0) = 1, low bits (0, 1, 1): 8 + 6 = entry 14.
        let mut values = [0.0; 64];
        values[0] = 8.0;
        values[1] = 16.0;
        values[2] = 32.0;
        values[7] = 64.0;
        values[14] = 128.0;
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        levels[0] = tensor(64, 1, &values);
        let grid = HashGrid { config: config(1, 1), levels };
        grid.validate().unwrap();
        let at = |u| encode(&grid, u)[0];
        assert_eq!(at([0.5, 0.5, 0.5]), 64.0);
        // u = 0 is the middle of the first cell: a mean of eight corners.
        assert_eq!(at([0.0; 3]), (8.0 + 16.0 + 32.0 + 64.0) / 8.0);
        // Halfway between (1, 1, 1) and (2, 1, 1).
        assert_eq!(at([1.0, 0.5, 0.5]), 96.0);
        // A quarter of the way, the position (1.25, 1, 1).
        assert_eq!(at([0.75, 0.5, 0.5]), 0.75 * 64.0 + 0.25 * 128.0);
        // Position (0.75, 0.5, 0.5): the x = 0 corners weigh 1/16 each, the x = 1 corners 3/16.
        assert_eq!(at([0.25, 0.0, 0.0]), (8.0 + 32.0 + 3.0 * 16.0 + 3.0 * 64.0) / 16.0);
        // Outside is clamped to the face.
        assert_eq!(at([1.5, 0.5, 0.5]), 96.0);
    }

    #[test]
    fn features_of_a_level_lie_together() {
        // Level 1 has 3 cells, 4 corners and 3 blocks along an axis: 216 entries
        // do not fit 64, so it is hashed. Constant tables interpolate to themselves.
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (level, value) in levels.iter_mut().zip([1.0, 3.0]) {
            let mut values = [0.0; 128];
            for (f, v) in values.iter_mut().enumerate() {
                *v = value + (f % 2) as f32;
            }
            *level = tensor(64, 2, &values);
        }
        let grid = HashGrid { config: config(2, 2), levels };
        grid.validate().unwrap();
        let out = encode(&grid, [0.3, 0.6, 0.9]);
        for (found, expected) in out[..5].iter().zip([1.0, 2.0, 3.0, 4.0, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn a_hashed_entry_by_hand() {
        // Corner (5, 2, 3): block (2, 1, 1), low bits (1, 0, 1) = 5. The table of 2^10
        // entries holds 128 blocks: only the low 7 bits count. 2654435761 = 0x9e3779b1
        // ends in 0x31 of 7 bits, 805459861 = 0x30025795 in 0x15:
        // 2 ^ 0x31 ^ 0x15 = 0x26 = 38, entry 8 * 38 + 5 = 309.
        let shape = LevelShape { scale: 31.0, shift: 0.5, numbering: Numbering::Hashed(128) };
        assert_eq!(shape.entry([5, 2, 3]), 309);
        // Corner (1, 64, 6): block (0, 32, 3), low bits 1. The low 7 bits of
        // 32 * 0x31 are 0x20, of 3 * 0x15 = 63 are 0x3f: 0x1f = 31, entry 249.
        assert_eq!(shape.entry([1, 64, 6]), 249);
    }

    #[test]
    fn a_hashed_level_reads_that_entry() {
        // Base resolution 33: 32 cells a unit length; u = 7.5 / 32 is corner 8. Block (4, 0, 0)
        // is number 4 of the hash, entry 32.
        let config = HashGridConfig { log2_hashmap_size: 10, base_resolution: 33, ..config(1, 1) };
        let mut values = [0.0; 1024];
        values[32] = 7.0;
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        levels[0] = tensor(1024, 1, &values);
        let grid = HashGrid { config, levels };
        grid.validate().unwrap();
        // y and z at u = 0 lie halfway between corners 0 and 1: a quarter of the value.
        assert_eq!(encode(&grid, [7.5 / 32.0, 0.0, 0.0])[0], 7.0 / 4.0);
    }

    #[test]
    fn levels_are_shaped_as_the_format_says() {
        for base_resolution in [2, 3, 7, 16, 33] {
            for per_level_scale in [1.0, 1.26, 1.381_913, 1.5, 2.0] {
                for log2_hashmap_size in [3, 10, 14, 19] {
                    let config = HashGridConfig {
                        n_levels: 16,
                        n_features_per_level: 2,
                        log2_hashmap_size,
                        base_resolution,
                        per_level_scale,
                        index: GridIndex::Blocked,
                    };
                    for l in 0..16 {
                        let (stated, own) = (config.level(l), LevelShape::new(&config, l));
                        assert_eq!(own.scale, f64::from(stated.scale));
                        let (entries, blocks) = match own.numbering {
                            Numbering::Dense(n) => (8 * n * n * n, n),
                            Numbering::Hashed(places) => (8 * places, 0),
                            _ => panic!("corners one by one"),
                        };
                        assert_eq!((entries, blocks), (stated.entries, stated.dense_side));
                        // The last corner that u = 1 reaches is in the table.
                        let last = (own.scale + 0.5) as u32 + 1;
                        assert!(own.entry([last; 3]) < entries as usize);
                    }
                }
            }
        }
    }

    mod corners {
        use super::*;
        use crate::Error;
        use crate::encoding::{CornerLevel, CornerLevels};

        fn grid(level: CornerLevel, shift: f32, values: &[f32]) -> HashGrid<'static> {
            let mut tables = [TensorView::EMPTY; MAX_LEVELS];
            tables[0] = tensor(values.len(), 1, values);
            let mut levels = [CornerLevel::default(); MAX_LEVELS];
            levels[0] = level;
            let index = GridIndex::Corners(CornerLevels { shift, levels });
            HashGrid { config: HashGridConfig { index, ..config(1, 1) }, levels: tables }
        }

        #[test]
        fn one_after_the_other_by_hand() {
            // Three cells, four corners along an axis: u = 2 / 3 with shift 0 is corner 2.
            // (2, 1, 0) is entry 2 + 4 = 6, (2, 1, 3) entry 2 + 4 + 48 = 54.
            let level = CornerLevel { scale: 3.0, side: 4, entries: 64 };
            let mut values = [0.0; 64];
            (values[6], values[54], values[0]) = (8.0, 16.0, 32.0);
            let first = grid(level, 0.0, &values);
            first.validate().unwrap();
            let at = |grid: &HashGrid<'_>, u| encode(grid, u)[0];
            let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-5);
            close(at(&first, [2.0 / 3.0, 1.0 / 3.0, 0.0]), 8.0);
            close(at(&first, [2.0 / 3.0, 1.0 / 3.0, 1.0]), 16.0);
            close(at(&first, [0.5, 1.0 / 3.0, 0.0]), 4.0);
            // Shifted by half a cell, u = 1 lies between corners 3 and 4. Corner (4, 4, 4),
            // 84, is entry 20; (4, 3, 3) is 64: entry 0. Others are not among the three.
            let mut values = [0.0; 64];
            (values[0], values[20]) = (32.0, 64.0);
            let shifted = grid(level, 0.5, &values);
            shifted.validate().unwrap();
            close(at(&shifted, [1.0; 3]), (32.0 + 64.0) / 8.0);
        }

        #[test]
        fn a_hashed_corner_by_hand() {
            // The low 6 bits of the primes are 0x31 and 0x15: (5, 2, 3) is
            // 5 ^ 0x62 ^ 0x3f = 0x58, of which 0x18 = 24 are left.
            let level = CornerLevel { scale: 32.0, side: 0, entries: 64 };
            let mut values = [0.0; 64];
            values[24] = 8.0;
            let hashed = grid(level, 0.0, &values);
            hashed.validate().unwrap();
            let u = [5.0, 2.0, 3.0].map(|c| c / 32.0);
            assert_eq!(encode(&hashed, u)[0], 8.0);
        }

        #[test]
        fn levels_that_reach_beyond_their_table_are_refused() {
            let sound = CornerLevel { scale: 3.0, side: 4, entries: 64 };
            let refused = [
                CornerLevel { side: 5, ..sound },
                CornerLevel { side: 3, entries: 27, ..sound },
                CornerLevel { side: 1, scale: 0.0, entries: 1 },
                CornerLevel { side: 0, entries: 63, ..sound },
                CornerLevel { side: 0, entries: 128, ..sound },
                CornerLevel { scale: f32::NAN, ..sound },
                CornerLevel { scale: -1.0, ..sound },
                CornerLevel { scale: 2_000_000.0, side: 0, ..sound },
            ];
            for level in refused {
                let found = grid(level, 0.5, &[0.0; 64]).config.validate();
                assert!(matches!(found, Err(Error::Range(_))), "{level:?}");
            }
            assert!(grid(sound, 1.5, &[0.0; 64]).config.validate().is_err());
            assert_eq!(grid(sound, 0.5, &[0.0; 64]).config.validate(), Ok(()));
        }
    }
}
