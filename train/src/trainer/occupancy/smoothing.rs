//! Cells that are alike: fewer bytes, packed, for as good a picture.

use rayon::prelude::*;

use super::cells::Packed;

impl Packed {
    /// The same but for cells of which at most `lone` of the 27 around and at them are occupied,
    /// which become empty, and those of which at least `full` are, which become occupied.
    pub(crate) fn smoothed(&self, lone: u8, full: u8) -> Self {
        let view = self.view();
        let n = view.resolution() as usize;
        let cell = |i: usize| [i % n, i / n % n, i / (n * n)].map(|c| c as u32);
        let occupied = |i| {
            let [x, y, z] = cell(i);
            u8::from(view.cell(x, y, z))
        };
        let own: Vec<u8> = (0..n * n * n).into_par_iter().map(occupied).collect();
        let mut around = own.clone();
        for stride in [1, n, n * n] {
            around = sums_of_three(&around, stride, n);
        }
        let is_left = |i: &usize| around[*i] >= full || (own[*i] == 1 && around[*i] > lone);
        Self::of(n as u32, (0..n * n * n).filter(is_left).map(|i| i as u32))
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
        let is_there = |cells: &Packed, [x, y, z]: [u32; 3]| cells.view().cell(x, y, z);
        let same = cells.smoothed(0, 28);
        assert_eq!(same.view().fraction(), cells.view().fraction());
        let filled = cells.smoothed(1, 26);
        assert!(is_there(&filled, [2; 3]) && is_there(&filled, [9; 3]));
        // Its corner at the grid's has eight of 27, those with an edge on two faces of the grid 12.
        let smooth = cells.smoothed(8, 18);
        assert!(is_there(&smooth, [2; 3]) && !is_there(&smooth, [9; 3]));
        assert!(!is_there(&smooth, [0; 3]) && is_there(&smooth, [1, 0, 0]));
        // Nothing wraps around.
        assert!(!is_there(&smooth, [15, 0, 0]));
    }
}
