//! Which cells of the unit cube may hold anything.
//!
//! Two levels: a *block* is 8×8×8 cells. `coarse` holds one little-endian
//! `u16` a block: 0 for a block without any occupied cell, else the number of
//! its fine part, counting from 1. `fine` holds 64 bytes for each such block,
//! one bit a cell: byte `y + 8 z`, bit `x` (coordinates within the block).
//! Blocks stand in the order `x + n (y + n z)`, n blocks along an axis.
//! Empty space thus costs two bytes per 512 cells.
//!
//! With `n_cascades > 1`, cascade c covers the cube of side 2^c around the
//! unit cube's centre, each with the same resolution; cascades follow one
//! another in `coarse` and share the numbering of `fine`.

mod skip_table;

use skip_table::Table;
pub(crate) use skip_table::{OCCUPIED, place};

use crate::Error;

/// Cells along one side of a block.
pub const BLOCK: u32 = 8;
/// Bytes of one block's fine bits.
pub const BLOCK_BYTES: usize = 64;

/// Borrowed occupancy of a field.
#[derive(Clone, Copy, Debug)]
pub struct Occupancy<'a> {
    resolution: u32,
    n_cascades: u32,
    coarse: &'a [[u8; 2]],
    fine: &'a [[u8; BLOCK_BYTES]],
    table: Table<'a>,
}

impl<'a> Occupancy<'a> {
    /// Checks sizes and every block number, O(blocks).
    ///
    /// `resolution` is cells along an axis: a multiple of 8 up to 512.
    ///
    /// # Errors
    /// [`Error::Range`] or [`Error::Shape`].
    pub fn new(
        resolution: u32,
        n_cascades: u32,
        coarse: &'a [u8],
        fine: &'a [u8],
    ) -> Result<Self, Error> {
        if resolution == 0 || resolution > 512 || !resolution.is_multiple_of(BLOCK) {
            return Err(Error::Range("occupancy resolution"));
        }
        if n_cascades == 0 || n_cascades > 8 {
            return Err(Error::Range("occupancy cascades"));
        }
        let n = (resolution / BLOCK) as usize;
        let (coarse, rest) = coarse.as_chunks::<2>();
        if !rest.is_empty() || coarse.len() != n * n * n * n_cascades as usize {
            return Err(Error::Shape("occupancy: coarse blocks and resolution"));
        }
        let (fine, rest) = fine.as_chunks::<BLOCK_BYTES>();
        if !rest.is_empty() {
            return Err(Error::Shape("occupancy: fine bits are not whole blocks"));
        }
        if coarse.iter().any(|b| usize::from(u16::from_le_bytes(*b)) > fine.len()) {
            return Err(Error::Shape("occupancy: a block number beyond the fine bits"));
        }
        Ok(Self { resolution, n_cascades, coarse, fine, table: Table::default() })
    }

    /// Cells along an axis.
    #[must_use]
    pub const fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Number of cascades, at least 1.
    #[must_use]
    pub const fn n_cascades(&self) -> u32 {
        self.n_cascades
    }

    /// The coarse blocks as bytes, as given to [`Occupancy::new`].
    #[must_use]
    pub const fn coarse_bytes(&self) -> &'a [u8] {
        self.coarse.as_flattened()
    }

    /// The fine bits as bytes, as given to [`Occupancy::new`].
    #[must_use]
    pub const fn fine_bytes(&self) -> &'a [u8] {
        self.fine.as_flattened()
    }

    /// The fine bits of a block of cascade 0, `None` where it is empty or
    /// outside the grid.
    #[inline(always)]
    #[must_use]
    pub fn block(&self, x: u32, y: u32, z: u32) -> Option<&'a [u8; BLOCK_BYTES]> {
        let n = self.resolution / BLOCK;
        if x >= n || y >= n || z >= n {
            return None;
        }
        let number = u16::from_le_bytes(*self.coarse.get((x + n * (y + n * z)) as usize)?);
        self.fine.get(usize::from(number).wrapping_sub(1))
    }

    /// Whether cell (x, y, z) of cascade 0 is occupied. False outside the grid.
    #[inline(always)]
    #[must_use]
    pub fn cell(&self, x: u32, y: u32, z: u32) -> bool {
        match self.block(x / BLOCK, y / BLOCK, z / BLOCK) {
            Some(bits) => {
                bits[((y % BLOCK) + BLOCK * (z % BLOCK)) as usize] >> (x % BLOCK) & 1 == 1
            }
            None => false,
        }
    }

    /// Whether the cell around unit point `u` is occupied. False outside the
    /// unit cube and for NaN.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, u: [f32; 3]) -> bool {
        if !u.iter().all(|v| (0.0..1.0).contains(v)) {
            return false;
        }
        let n = self.resolution as f32;
        self.cell((u[0] * n) as u32, (u[1] * n) as u32, (u[2] * n) as u32)
    }

    /// Fraction of the grid's cells that are occupied.
    #[must_use]
    pub fn fraction(&self) -> f32 {
        let mut ones = 0u64;
        for number in self.coarse {
            let number = usize::from(u16::from_le_bytes(*number));
            if let Some(bits) = self.fine.get(number.wrapping_sub(1)) {
                ones += bits.iter().map(|b| u64::from(b.count_ones())).sum::<u64>();
            }
        }
        ones as f32 / (self.coarse.len() as f32 * 512.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_one_cell_that_is_set() {
        // 16³ cells: 2³ blocks; block (1, 0, 1) = number 5 holds cell (10, 3, 12).
        let mut coarse = [0u8; 16];
        coarse[5 * 2] = 1;
        let mut fine = [0u8; 64];
        fine[3 + 8 * 4] = 1 << 2;
        let occupancy = Occupancy::new(16, 1, &coarse, &fine).unwrap();
        for z in 0..17 {
            for y in 0..17 {
                for x in 0..17 {
                    assert_eq!(occupancy.cell(x, y, z), (x, y, z) == (10, 3, 12));
                }
            }
        }
        assert!(occupancy.at([10.5 / 16.0, 3.5 / 16.0, 12.5 / 16.0]));
        assert!(!occupancy.at([f32::NAN, 0.2, 0.8]) && !occupancy.at([1.0, 0.2, 0.8]));
        assert_eq!(occupancy.fraction(), 1.0 / 4096.0);
    }

    #[test]
    fn refuses_what_does_not_fit() {
        assert!(Occupancy::new(12, 1, &[], &[]).is_err());
        assert!(Occupancy::new(8, 0, &[0, 0], &[]).is_err());
        assert!(Occupancy::new(8, 1, &[0, 0, 0], &[]).is_err());
        assert!(Occupancy::new(8, 1, &[1, 0], &[]).is_err());
        assert!(Occupancy::new(8, 1, &[1, 0], &[0; 63]).is_err());
        assert!(Occupancy::new(8, 1, &[1, 0], &[0; 64]).is_ok());
    }
}
