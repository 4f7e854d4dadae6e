//! Sets of cells: as core reads them, and with all their neighbours.

use std::sync::OnceLock;

use pocketnerf_core::occupancy::{BLOCK, BLOCK_BYTES};
use pocketnerf_core::{Error, Occupancy, Space};
use rayon::prelude::*;

/// The cells of an occupancy and all their neighbours, a bit a cell.
pub(crate) struct Grown {
    resolution: usize,
    /// Words of a row along x.
    words: usize,
    bits: Vec<u64>,
}

impl Grown {
    pub(crate) fn new(occupancy: &Occupancy<'_>) -> Self {
        let n = occupancy.resolution() as usize;
        let words = n.div_ceil(64);
        let mut bits = vec![0u64; words * n * n];
        let blocks = occupancy.resolution() / BLOCK;
        for block in 0..blocks * blocks * blocks {
            let corner = [block % blocks, block / blocks % blocks, block / (blocks * blocks)];
            let Some(bytes) = occupancy.block(corner[0], corner[1], corner[2]) else { continue };
            let [x, y, z] = corner.map(|c| (c * BLOCK) as usize);
            for (i, byte) in bytes.iter().enumerate() {
                let row = (y + i % 8) + n * (z + i / 8);
                bits[row * words + x / 64] |= u64::from(*byte) << (x % 64);
            }
        }
        // Along x within the rows, then rows with rows, then planes with planes.
        for row in bits.chunks_exact_mut(words) {
            let mut carry = 0;
            for w in 0..words {
                let (word, next) = (row[w], row.get(w + 1).copied().unwrap_or(0));
                row[w] = word | word << 1 | word >> 1 | carry | next << 63;
                carry = word >> 63;
            }
        }
        for plane in bits.chunks_exact_mut(words * n) {
            spread(plane, words);
        }
        spread(&mut bits, words * n);
        Self { resolution: n, words, bits }
    }

    /// In ascending order of `x + n (y + n z)`.
    pub(crate) fn cells(&self) -> impl Iterator<Item = u32> {
        let full = self.bits.iter().enumerate().filter(|(_, word)| **word != 0);
        full.flat_map(move |(i, word)| {
            let (row, first) = (i / self.words, i % self.words * 64);
            // A row may end within a word.
            let columns = first..(first + 64).min(self.resolution);
            let set = columns.filter(move |x| word >> (x - first) & 1 == 1);
            set.map(move |x| (row * self.resolution + x) as u32)
        })
    }
}

/// Every part of `len` words becomes its union with the part before and the one after.
fn spread(bits: &mut [u64], len: usize) {
    let mut before = vec![0; len];
    for start in (0..bits.len()).step_by(len) {
        let (part, after) = bits[start..].split_at_mut(len);
        for (i, word) in part.iter_mut().enumerate() {
            let own = *word;
            *word |= before[i] | after.get(i).copied().unwrap_or(0);
            before[i] = own;
        }
    }
}

/// Cells along an axis of which any set can be [packed](pack): 32³ blocks at most.
pub(crate) const MOST_CELLS: u32 = 256;

/// Coarse blocks and fine bits of some cells, as core reads them.
///
/// # Errors
/// [`Error::Range`] where more than 65,535 blocks hold cells: they are numbered in 16 bits.
pub fn pack(
    resolution: u32,
    cells: impl Iterator<Item = u32>,
) -> Result<(Vec<u8>, Vec<u8>), Error> {
    let n = resolution;
    let blocks = n / BLOCK;
    let mut bits: Vec<Option<Box<[u8; BLOCK_BYTES]>>> =
        vec![None; (blocks * blocks * blocks) as usize];
    for cell in cells {
        let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
        let block = x / BLOCK + blocks * (y / BLOCK + blocks * (z / BLOCK));
        let bytes = bits[block as usize].get_or_insert_with(|| Box::new([0; BLOCK_BYTES]));
        bytes[(y % BLOCK + BLOCK * (z % BLOCK)) as usize] |= 1 << (x % BLOCK);
    }
    let mut coarse = Vec::with_capacity(bits.len() * 2);
    let mut fine = Vec::new();
    for block in bits {
        let mut number = 0u16;
        if let Some(bytes) = block {
            fine.extend_from_slice(&bytes[..]);
            let blocks = fine.len() / BLOCK_BYTES;
            number =
                u16::try_from(blocks).map_err(|_| Error::Range("number of occupied blocks"))?;
        }
        coarse.extend(number.to_le_bytes());
    }
    Ok((coarse, fine))
}

/// Cells as core reads them, and a table of what lies around each, once it is asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Packed {
    resolution: u32,
    coarse: Vec<u8>,
    fine: Vec<u8>,
    table: OnceLock<Vec<u8>>,
}

impl Packed {
    /// Of some cells, of at most [`MOST_CELLS`] along an axis.
    pub(crate) fn of(resolution: u32, cells: impl Iterator<Item = u32>) -> Self {
        let (coarse, fine) = pack(resolution, cells).expect("so few have numbers");
        Self::new(resolution, coarse, fine).expect("packed for this resolution")
    }

    /// Of coarse blocks and fine bits.
    pub(crate) fn new(resolution: u32, coarse: Vec<u8>, fine: Vec<u8>) -> Result<Self, Error> {
        Occupancy::new(resolution, 1, &coarse, &fine)?;
        Ok(Self { resolution, coarse, fine, table: OnceLock::new() })
    }

    /// Those of the cells, by their numbers along the axes, that are `kept`.
    pub(crate) fn only(&self, kept: impl Fn([u32; 3]) -> bool) -> Self {
        let (n, view) = (self.resolution, self.view());
        let at = |cell: &u32| {
            let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
            view.cell(x, y, z) && kept([x, y, z])
        };
        Self::of(n, (0..n * n * n).filter(at))
    }

    /// For core to march through.
    pub(crate) fn view(&self) -> Occupancy<'_> {
        let occupancy = self.bare();
        let table = self.table.get_or_init(|| {
            let mut table = vec![0; occupancy.table_len()];
            occupancy.write_table(&mut table).expect("as long as it has to be");
            table
        });
        occupancy.with_table(table).expect("written for these cells")
    }

    /// The cells alone: a GPU has a table of its own.
    pub(crate) fn bare(&self) -> Occupancy<'_> {
        let occupancy = Occupancy::new(self.resolution, 1, &self.coarse, &self.fine);
        occupancy.expect("checked when it was packed")
    }
}

/// The cells of an occupancy and all their neighbours.
#[must_use]
pub fn dilated(occupancy: &Occupancy<'_>) -> Vec<u32> {
    let n = occupancy.resolution();
    let near = |c: u32| c.saturating_sub(1)..(c + 2).min(n);
    (0..n * n * n)
        .into_par_iter()
        .filter(|cell| {
            let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
            near(z).any(|z| near(y).any(|y| near(x).any(|x| occupancy.cell(x, y, z))))
        })
        .collect()
}

/// Every cell of the cube that lies in the box of the space.
pub(crate) fn all_cells(space: &Space, resolution: u32) -> Vec<u32> {
    let n = resolution;
    let map = space.unit_map();
    let [_, max] = space.bounds();
    let end = map.apply(max).map(|u| (u * n as f32).ceil() as u32);
    let inside = |cell: &u32| {
        let corner = [cell % n, cell / n % n, cell / (n * n)];
        // Contracted space ends where two coordinates lie beyond its cube.
        let beyond = corner.iter().filter(|c| **c < n / 4 || **c >= n - n / 4).count();
        (0..3).all(|a| corner[a] < end[a]) && (beyond < 2 || !space.is_bent())
    };
    (0..n * n * n).filter(inside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn packs_and_dilates() {
        let (coarse, fine) = pack(16, [5u32, 16 * 16 * 15 + 16 * 15 + 15].into_iter()).unwrap();
        let occupancy = Occupancy::new(16, 1, &coarse, &fine).unwrap();
        assert!(occupancy.cell(5, 0, 0) && occupancy.cell(15, 15, 15));
        assert_eq!(occupancy.fraction(), 2.0 / 4096.0);
        let grown = dilated(&occupancy);
        // A cell on a face grows to 3 × 2 × 2, one in a corner to 2 × 2 × 2.
        assert_eq!(grown.len(), 12 + 8);
        assert!(grown.contains(&(4 + 16 + 256)) && !grown.contains(&3));
    }

    #[test]
    fn blocks_without_a_number_are_refused() {
        // The first cell of each of so many of 64³ blocks.
        let first = |block: u32| {
            let corner = [block % 64, block / 64 % 64, block / 4096].map(|c| c * BLOCK);
            corner[0] + 512 * (corner[1] + 512 * corner[2])
        };
        let (coarse, fine) = pack(512, (0..65_535).map(first)).unwrap();
        let occupancy = Occupancy::new(512, 1, &coarse, &fine).unwrap();
        assert_eq!((occupancy.fraction() * 512f64.powi(3) as f32).round(), 65_535.0);
        assert_eq!(coarse[2 * 65_534..][..2], [0xff, 0xff]);
        let error = pack(512, (0..65_536).map(first)).unwrap_err();
        assert_eq!(error, Error::Range("number of occupied blocks"));
        // As many cells as training has at most: every block has one.
        assert!(pack(MOST_CELLS, 0..MOST_CELLS.pow(3)).is_ok());
    }

    #[test]
    fn grows_as_dilation_says() {
        for resolution in [16, 72, 128] {
            let mut random = Random::new(3, [resolution.into(), 0, 0]);
            let cells: Vec<u32> = (0..40)
                .map(|_| random.below((resolution * resolution * resolution) as usize) as u32)
                .chain([0, resolution - 1, resolution * resolution * resolution - 1])
                .collect();
            let (coarse, fine) = pack(resolution, cells.into_iter()).unwrap();
            let occupancy = Occupancy::new(resolution, 1, &coarse, &fine).unwrap();
            let near = Grown::new(&occupancy);
            assert_eq!(near.cells().collect::<Vec<_>>(), dilated(&occupancy));
        }
    }
}
