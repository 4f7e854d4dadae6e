//! Cells that are alike: fewer bytes, packed, for as good a picture.

use pocketnerf_core::occupancy::BLOCK;
use rayon::prelude::*;

use super::cells::Packed;

/// How many of the 27 cells around and at each one are occupied.
pub(crate) struct Neighbours<'c> {
    cells: &'c Packed,
    counts: Vec<u8>,
}

impl<'c> Neighbours<'c> {
    pub(crate) fn of(cells: &'c Packed) -> Self {
        let view = cells.view();
        let n = view.resolution() as usize;
        let mut counts = vec![0; n * n * n];
        let blocks = view.resolution() / BLOCK;
        for block in 0..blocks * blocks * blocks {
            let corner = [block % blocks, block / blocks % blocks, block / (blocks * blocks)];
            let Some(bytes) = view.block(corner[0], corner[1], corner[2]) else { continue };
            let [x, y, z] = corner.map(|c| (c * BLOCK) as usize);
            for (i, bits) in bytes.iter().enumerate() {
                let row = x + n * (y + i % 8 + n * (z + i / 8));
                for (bit, cell) in counts[row..][..8].iter_mut().enumerate() {
                    *cell = bits >> bit & 1;
                }
            }
        }
        for stride in [1, n, n * n] {
            counts = sums_of_three(&counts, stride, n);
        }
        Self { cells, counts }
    }

    /// The cells but for those that have at most `lone`, which become empty, and with those that have
    /// at least `full` and, by their numbers along the axes, are `known`.
    pub(crate) fn smoothed(&self, lone: u8, full: u8, known: impl Fn([u32; 3]) -> bool) -> Packed {
        let view = self.cells.view();
        let n = view.resolution();
        let is_left = |&(cell, count): &(u32, u8)| {
            let at = [cell % n, cell / n % n, cell / (n * n)];
            let [x, y, z] = at;
            count > lone && (view.cell(x, y, z) || (count >= full && known(at)))
        };
        let counts = (0..n * n * n).zip(self.counts.iter().copied());
        Packed::of(n, counts.filter(is_left).map(|(cell, _)| cell))
    }
}

/// Each value and its two neighbours along an axis of `n` values, which lie `stride` apart.
fn sums_of_three(values: &[u8], stride: usize, n: usize) -> Vec<u8> {
    let mut sums = values.to_vec();
    let lines = sums.par_chunks_mut(stride * n).zip(values.par_chunks(stride * n));
    lines.for_each(|(sums, values)| {
        let all = stride * (n - 1);
        for (sum, value) in sums[stride..].iter_mut().zip(&values[..all]) {
            *sum += value;
        }
        for (sum, value) in sums[..all].iter_mut().zip(&values[stride..]) {
            *sum += value;
        }
    });
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lone_cells_vanish_and_holes_are_filled() {
        const N: u32 = 16;
        let number = |[x, y, z]: [u32; 3]| x + N * (y + N * z);
        // A cube with a hole, whose corner is the grid's, and two cells elsewhere.
        let cube = (0..4u32.pow(3)).map(|i| [i % 4, i / 4 % 4, i / 16]).filter(|c| *c != [2; 3]);
        let others = [[9, 9, 9], [10, 10, 10]];
        let cells = Packed::of(N, cube.chain(others).map(number));
        let near = Neighbours::of(&cells);
        let is_there = |cells: &Packed, [x, y, z]: [u32; 3]| cells.view().cell(x, y, z);
        let same = near.smoothed(0, 28, |_| true);
        assert_eq!(same.view().fraction(), cells.view().fraction());
        let filled = near.smoothed(1, 26, |_| true);
        assert!(is_there(&filled, [2; 3]) && is_there(&filled, [9; 3]));
        assert!(!is_there(&near.smoothed(1, 26, |cell| cell != [2; 3]), [2; 3]));
        // Its corner at the grid's has eight of 27, those with an edge on two faces of the grid 12.
        let smooth = near.smoothed(8, 18, |_| true);
        assert!(is_there(&smooth, [2; 3]) && !is_there(&smooth, [9; 3]));
        assert!(!is_there(&smooth, [0; 3]) && is_there(&smooth, [1, 0, 0]));
        // Nothing wraps around.
        assert!(!is_there(&smooth, [15, 0, 0]));
    }
}
