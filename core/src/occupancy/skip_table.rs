//! What lies around a cell, and how far rays can go without another look.

use super::{BLOCK, BLOCK_BYTES, Occupancy};
use crate::Error;

/// A cell and what is like it: the lower bits are the side, in cells, of the largest
/// of the cubes of 8, 4, 2 and 1 cells around it whose cells are all occupied or all
/// empty; a table knows of empty cubes of 32 and 16 too. [`OCCUPIED`] says which.
pub(crate) type Neighbourhood = u8;

/// The bit of [`Neighbourhood`] that says that the cell is occupied.
pub(crate) const OCCUPIED: Neighbourhood = 0x80;
/// A block without occupied cells, and all that is outside the grid.
const EMPTY: Neighbourhood = BLOCK as u8;
/// Cubes of 2×2×2 cells in a block.
const CUBES: usize = BLOCK_BYTES;
/// Empty cubes of 1, 2 and 4 blocks a side: the first rows of a table.
const EMPTY_ROWS: usize = 3;

/// What lies around every cell, as a table.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Table<'a> {
    /// The row of each block, little-endian; nothing where there is no table.
    row_of: &'a [[u8; 2]],
    /// A block's cubes of 2×2×2 cells: of [`EMPTY_ROWS`] kinds of empty blocks, then
    /// of those with fine bits.
    rows: &'a [[Cube; CUBES]],
}

/// A bit for each of 2×2×2 cells, x first: whether it is occupied; and the side of
/// the largest cube around all of them whose cells are alike, 1 where they are not.
type Cube = [u8; 2];

/// Where a cell lies in its block: `8 cube + corner`. Cubes of 2×2×2 cells stand in
/// the order `x + 4 (y + 4 z)`, a cube's cells in the order `x + 2 (y + 2 z)`.
#[inline(always)]
pub(crate) fn place<T>([x, y, z]: [T; 3]) -> T
where
    T: Copy
        + core::ops::Shr<u32, Output = T>
        + core::ops::Shl<u32, Output = T>
        + core::ops::BitAnd<u32, Output = T>
        + core::ops::BitOr<T, Output = T>,
{
    let cube = x >> 1 | (y >> 1) << 2 | (z >> 1) << 4;
    cube << 3 | (x & 1) | (y & 1) << 1 | (z & 1) << 2
}

/// The cell at a [`place`].
fn cell(place: u32) -> [u32; 3] {
    let axis = |a: u32| (place >> (3 + 2 * a) & 3) << 1 | (place >> a & 1);
    [axis(0), axis(1), axis(2)]
}

impl<'a> Occupancy<'a> {
    /// Bytes that [`write_table`](Self::write_table) needs: 2 a block, 128 more one
    /// that holds anything, and 384.
    #[must_use]
    pub const fn table_len(&self) -> usize {
        2 * self.coarse.len() + (EMPTY_ROWS + self.fine.len()) * size_of::<[Cube; CUBES]>()
    }

    /// Writes down what lies around each cell, for [`with_table`](Self::with_table).
    ///
    /// # Errors
    /// [`Error::OutputLength`] where `memory` holds fewer than
    /// [`table_len`](Self::table_len) bytes.
    pub fn write_table(&self, memory: &mut [u8]) -> Result<(), Error> {
        let (needed, given) = (self.table_len(), memory.len());
        let memory = memory.get_mut(..needed).ok_or(Error::OutputLength { needed, given })?;
        let (row_of, rows) = memory.split_at_mut(2 * self.coarse.len());
        for (block, to) in row_of.as_chunks_mut().0.iter_mut().enumerate() {
            *to = self.row_of(block).to_le_bytes();
        }
        let rows = rows.as_chunks_mut::<2>().0.as_chunks_mut::<CUBES>().0;
        let (empty, full) = rows.split_at_mut(EMPTY_ROWS);
        for (kind, row) in empty.iter_mut().enumerate() {
            row.fill([0, EMPTY << kind]);
        }
        for (row, fine) in full.iter_mut().zip(self.fine) {
            for (cube, to) in row.iter_mut().enumerate() {
                let around = |corner: u32| neighbourhood(fine, 8 * cube as u32 + corner);
                let occupied = |corner: u32| (around(corner) / OCCUPIED) << corner;
                *to = [(0..8).map(occupied).sum(), around(0) % OCCUPIED];
            }
        }
        Ok(())
    }

    /// The same cells with the table that [`write_table`](Self::write_table) wrote
    /// for them: rays cross them in less time, and find the same. Without a table
    /// where more blocks hold something than it can number, 65,532.
    ///
    /// # Errors
    /// [`Error::Shape`] where its length is not [`table_len`](Self::table_len).
    pub fn with_table<'b>(&self, table: &'b [u8]) -> Result<Occupancy<'b>, Error>
    where
        'a: 'b,
    {
        if table.len() != self.table_len() {
            return Err(Error::Shape("occupancy: cells and their table"));
        }
        if self.fine.len() + EMPTY_ROWS > usize::from(u16::MAX) {
            // More rows than can be numbered; such a scene has no space to cross.
            return Ok(*self);
        }
        let (row_of, rows) = table.split_at(2 * self.coarse.len());
        let rows = rows.as_chunks().0.as_chunks().0;
        let table = Table { row_of: row_of.as_chunks().0, rows };
        Ok(Occupancy { table, ..*self })
    }

    /// The row of a block in a table.
    fn row_of(&self, block: usize) -> u16 {
        let number = |block: usize| self.coarse.get(block).map_or(0, |b| u16::from_le_bytes(*b));
        if number(block) > 0 {
            return (number(block) - 1).saturating_add(EMPTY_ROWS as u16);
        }
        let n = (self.resolution / BLOCK) as usize;
        // Cascades lie one behind another along z.
        let corner = [block % n, block / n % n, block / (n * n)];
        let is_empty = |side: usize| {
            let low = corner.map(|c| c - c % side);
            let blocks = |a: usize| low[a]..(low[a] + side).min(n);
            corner[2] < n
                && blocks(2)
                    .all(|z| blocks(1).all(|y| blocks(0).all(|x| number(x + n * (y + n * z)) == 0)))
        };
        (1..EMPTY_ROWS).take_while(|kind| is_empty(1 << kind)).count() as u16
    }

    /// The side, in blocks, of the largest cube of empty blocks around a block of
    /// cascade 0 that is known; 0 where the block holds anything, no end outside the grid.
    pub(crate) fn empty_blocks(&self, [x, y, z]: [u32; 3]) -> u32 {
        let n = self.resolution / BLOCK;
        if x >= n || y >= n || z >= n {
            return u32::MAX;
        }
        let block = (x + n * (y + n * z)) as usize;
        match self.table.row_of.get(block).map(|row| u16::from_le_bytes(*row)) {
            Some(row) if usize::from(row) < EMPTY_ROWS => 1 << row,
            Some(_) => 0,
            None => u32::from(self.coarse.get(block).is_none_or(|number| *number == [0; 2])),
        }
    }

    /// What lies around the cell at a [`place`] of the block with this number.
    #[inline(always)]
    pub(crate) fn around(&self, block: u32, place: u32) -> Neighbourhood {
        if !self.table.row_of.is_empty() {
            // Without branches: where a ray is, is hard to predict.
            let row = self.table.row_of.get(block as usize).map_or(0, |r| u16::from_le_bytes(*r));
            let row = self.table.rows.get(usize::from(row));
            let [cells, side] = row.map_or([0, EMPTY], |row| row[place as usize / 8 % CUBES]);
            return (cells >> (place % 8)) << 7 | side;
        }
        let number = self.coarse.get(block as usize).map_or(0, |b| u16::from_le_bytes(*b));
        match self.fine.get(usize::from(number).wrapping_sub(1)) {
            Some(fine) => neighbourhood(fine, place),
            None => EMPTY,
        }
    }
}

/// What lies around the cell at a [`place`] of a block.
fn neighbourhood(fine: &[u8; BLOCK_BYTES], place: u32) -> Neighbourhood {
    let [x, y, z] = cell(place);
    // A layer of 8×8 cells is a word: a row is a byte.
    let layers = fine.as_chunks::<8>().0;
    let layer = |z: u32| u64::from_le_bytes(layers[(z % BLOCK) as usize]);
    let occupied = layer(z) >> (8 * y + x) & 1;
    // A bit for every cell that is unlike this one.
    let unlike = |z: u32| layer(z) ^ occupied.wrapping_neg();
    let two = z & 6;
    let pair = unlike(two) | unlike(two + 1);
    let other = unlike(two ^ 2) | unlike((two ^ 2) + 1);
    let alike = |cells: u64, mask: u64, side: u32| {
        let (x, y) = (x & !(side - 1), y & !(side - 1));
        cells >> (8 * y + x) & mask == 0
    };
    let two = alike(pair, 0x0303, 2);
    let four = two && alike(pair | other, 0x0f0f_0f0f, 4);
    1 << (u8::from(two) + u8::from(four)) | (occupied as u8) << 7
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;

    /// One block of 16³ cells.
    fn with_block<T>(fine: [u8; BLOCK_BYTES], each: impl Fn(&Occupancy<'_>) -> T) -> T {
        let mut coarse = [0u8; 16];
        coarse[0] = 1;
        each(&Occupancy::new(16, 1, &coarse, &fine).unwrap())
    }

    #[test]
    fn cubes_by_hand() {
        // Cell (5, 2, 7) is occupied.
        let mut fine = [0u8; 64];
        fine[2 + 8 * 7] = 1 << 5;
        let cells = [
            ([5, 2, 7], 1 | OCCUPIED),
            ([4, 2, 7], 1),
            ([5, 3, 7], 1),
            ([5, 2, 6], 1),
            ([6, 2, 7], 2),
            ([5, 1, 7], 2),
            ([5, 2, 5], 2),
            ([3, 2, 7], 4),
            ([5, 4, 7], 4),
            ([5, 2, 3], 4),
        ];
        let empty = Occupancy::new(16, 1, &[0; 16], &fine).unwrap();
        assert_eq!(empty.around(0, 0), 8);
        for ([x, y, z], expected) in cells {
            let bit = place([x, y, z]);
            assert_eq!(cell(bit), [x, y, z]);
            with_block(fine, |occupancy| {
                assert_eq!(occupancy.around(0, bit), expected, "{x} {y} {z}");
                assert_eq!((occupancy.around(1, bit), occupancy.around(u32::MAX, 0)), (8, 8));
            });
            // The same cell where all others are occupied.
            with_block(fine.map(|byte| !byte), |occupancy| {
                assert_eq!(occupancy.around(0, bit), expected ^ OCCUPIED, "{x} {y} {z}");
            });
        }
        with_block(fine, |occupancy| {
            let mut memory = vec![0xff; occupancy.table_len()];
            occupancy.write_table(&mut memory).unwrap();
            let with_table = occupancy.with_table(&memory).unwrap();
            for block in [0, 1, 7, 8, u32::MAX] {
                for bit in 0..512 {
                    assert_eq!(with_table.around(block, bit), occupancy.around(block, bit));
                }
            }
        });
    }

    #[test]
    fn tables_know_of_large_empty_cubes() {
        // 72³ cells, 9³ blocks; block (5, 0, 2) holds something.
        let mut coarse = [0u8; 2 * 9 * 9 * 9];
        let block = |x: u32, y: u32, z: u32| x + 9 * (y + 9 * z);
        coarse[2 * block(5, 0, 2) as usize] = 1;
        let occupancy = Occupancy::new(72, 1, &coarse, &[0xff; 64]).unwrap();
        let mut table = vec![0; occupancy.table_len()];
        occupancy.write_table(&mut table).unwrap();
        let occupancy = occupancy.with_table(&table).unwrap();
        assert_eq!(occupancy.around(block(5, 0, 2), 77), 4 | OCCUPIED);
        assert_eq!(occupancy.around(block(4, 0, 2), 77), 8);
        assert_eq!(occupancy.around(block(5, 1, 3), 77), 8);
        assert_eq!(occupancy.around(block(6, 0, 2), 77), 16);
        assert_eq!(occupancy.around(block(7, 3, 1), 77), 16);
        assert_eq!(occupancy.around(block(3, 0, 2), 77), 32);
        assert_eq!(occupancy.around(block(5, 0, 4), 77), 32);
        // Cubes may reach beyond the grid, where nothing is.
        assert_eq!(occupancy.around(block(8, 8, 8), 77), 32);
        assert_eq!(occupancy.around(9 * 9 * 9, 0), 8);
    }

    #[test]
    fn a_table_needs_its_memory() {
        with_block([0; 64], |occupancy| {
            let needed = 2 * 8 + 4 * 128;
            assert_eq!(occupancy.table_len(), needed);
            let error = occupancy.write_table(&mut vec![0; needed - 1]).unwrap_err();
            assert_eq!(error, Error::OutputLength { needed, given: needed - 1 });
            assert!(occupancy.with_table(&vec![0; needed - 1]).is_err());
            assert!(occupancy.with_table(&vec![0; needed + 1]).is_err());
        });
    }
}
