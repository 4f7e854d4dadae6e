//! Which bricks of a grid of voxels are kept, and which of them a thread updates.

use pocketnerf_core::Occupancy;
use pocketnerf_core::encoding::voxel_grid::{BRICK, bricks_along};

/// Slabs that bricks are cut into along z, at any number of threads.
pub(super) const SLABS: usize = 16;

/// The bricks that are kept, numbered from 1 row after row.
#[derive(Debug, PartialEq)]
pub(super) struct Bricks {
    /// Of each, its number; 0: it holds nothing.
    numbers: Vec<u16>,
    /// Along an axis.
    along: u32,
    /// All that there are, the one that holds nothing included.
    len: usize,
    /// Numbers of the bricks beside each: before and behind it along x, y and z.
    beside: Vec<[u16; 6]>,
    /// The slab of each layer along z.
    slab_of_layer: Vec<u8>,
    /// First brick of each slab, and the end.
    firsts: [usize; SLABS + 1],
}

impl Bricks {
    /// Those for which `is_kept` says so; `None` for too many.
    fn which(resolution: u32, is_kept: impl Fn([u32; 3]) -> bool) -> Option<Self> {
        let along = bricks_along(resolution);
        let mut last = 0u16;
        let mut number = |place: u32| {
            let place = [place % along, place / along % along, place / (along * along)];
            if !is_kept(place) {
                return Some(0);
            }
            last = last.checked_add(1)?;
            Some(last)
        };
        let numbers: Option<Vec<u16>> = (0..along.pow(3)).map(&mut number).collect();
        Some(Self::numbered(numbers?, along))
    }

    fn numbered(numbers: Vec<u16>, along: u32) -> Self {
        let layer = (along * along) as usize;
        let of = |numbers: &[u16]| numbers.iter().filter(|number| **number > 0).count();
        let len = 1 + of(&numbers);
        let mut slab_of_layer = Vec::with_capacity(along as usize);
        let mut firsts = [len; SLABS + 1];
        firsts[0] = 1;
        let mut before = 1;
        for layer in numbers.chunks_exact(layer) {
            // About as many bricks in each slab.
            let slab = (before - 1) * SLABS / len;
            for first in &mut firsts[1..=slab] {
                *first = (*first).min(before);
            }
            slab_of_layer.push(slab as u8);
            before += of(layer);
        }
        let beside = Vec::new();
        let mut bricks = Self { numbers, along, len, beside, slab_of_layer, firsts };
        let number = |place: [u32; 3]| {
            let [x, y, z] = place;
            let is_there = place.iter().all(|c| *c < along);
            if is_there { bricks.numbers[(x + along * (y + along * z)) as usize] } else { 0 }
        };
        let beside = bricks.places().map(|place| {
            let Some(place) = place else { return [0; 6] };
            std::array::from_fn(|side| {
                let mut place = place;
                let c = &mut place[side / 2];
                *c = if side % 2 == 0 { c.wrapping_sub(1) } else { *c + 1 };
                number(place)
            })
        });
        bricks.beside = beside.collect();
        bricks
    }

    /// The rows beside a row along an axis, before and behind it; `None` where their brick is not
    /// kept.
    #[inline(always)]
    pub(super) fn rows_beside(&self, row: usize, axis: usize) -> [Option<usize>; 2] {
        let (brick, length) = (row / BRICK, [1, 4, 16][axis]);
        let at = row / length % 4;
        let there =
            |number: u16, corner: usize| (number > 0).then(|| BRICK * usize::from(number) + corner);
        let within = row % BRICK;
        let before = match at {
            0 => there(self.beside[brick][2 * axis], within + 3 * length),
            _ => Some(row - length),
        };
        let behind = match at {
            3 => there(self.beside[brick][2 * axis + 1], within - 3 * length),
            _ => Some(row + length),
        };
        [before, behind]
    }

    /// All.
    pub(super) fn all(resolution: u32) -> Self {
        // A finer grid than can be kept whole is never built without cells.
        let fits = |resolution: &u32| bricks_along(*resolution).pow(3) < 1 << 16;
        let most = (1..=resolution / 4).rev().map(|n| 4 * n).find(fits).unwrap_or(4);
        Self::which(most, |_| true).expect("as many as there are numbers")
    }

    /// Those with a corner of a voxel that touches a cell; `None` for too many.
    pub(super) fn around(cells: &Occupancy<'_>, resolution: u32) -> Option<Self> {
        let (along, n) = (bricks_along(resolution), cells.resolution());
        let mut kept = vec![false; along.pow(3) as usize];
        // The bricks of all corners around the points of a cell.
        let range = |c: u32| {
            let [low, high] = [c * resolution / n, ((c + 1) * resolution).div_ceil(n)];
            low / 4..=(high / 4).min(along - 1)
        };
        for cell in 0..n.pow(3) {
            let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
            if !cells.cell(x, y, z) {
                continue;
            }
            for z in range(z) {
                for y in range(y) {
                    for x in range(x) {
                        kept[(x + along * (y + along * z)) as usize] = true;
                    }
                }
            }
        }
        Self::which(resolution, |[x, y, z]| kept[(x + along * (y + along * z)) as usize])
    }

    /// Those of a model, in which there are so many; `None` where they are numbered otherwise.
    pub(super) fn read(bytes: &[u8], resolution: u32, len: usize) -> Option<Self> {
        let along = bricks_along(resolution);
        let numbers: Vec<u16> =
            bytes.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
        let mut last = 0;
        let in_order = numbers.iter().filter(|number| **number > 0).all(|number| {
            last += 1;
            usize::from(*number) == last
        });
        let bricks = (numbers.len() == along.pow(3) as usize && in_order)
            .then(|| Self::numbered(numbers, along))?;
        (bricks.len == len).then_some(bricks)
    }

    /// How many there are, the one that holds nothing included.
    pub(super) const fn len(&self) -> usize {
        self.len
    }

    /// The number of each place.
    pub(super) fn numbers(&self) -> &[u16] {
        &self.numbers
    }

    /// The place of each brick; `None` for the one that holds nothing.
    pub(super) fn places(&self) -> impl Iterator<Item = Option<[u32; 3]>> {
        let n = self.along;
        let place = move |at: u32| [at % n, at / n % n, at / (n * n)];
        let kept = (0..).zip(&self.numbers).filter(|(_, number)| **number > 0);
        std::iter::once(None).chain(kept.map(move |(at, _)| Some(place(at))))
    }

    /// The row of a corner's values; `None` where its brick is not kept.
    pub(super) fn row_of(&self, corner: [u32; 3]) -> Option<usize> {
        let [x, y, z] = corner.map(|c| (c / 4).min(self.along - 1));
        let number = self.numbers[(x + self.along * (y + self.along * z)) as usize];
        let within = corner[0] % 4 + 4 * (corner[1] % 4) + 16 * (corner[2] % 4);
        (number > 0).then_some(BRICK * usize::from(number) + within as usize)
    }

    /// The slab that a layer along z lies in.
    pub(super) fn slab_of_layer(&self, layer: usize) -> usize {
        usize::from(self.slab_of_layer[layer.min(self.slab_of_layer.len() - 1)])
    }

    /// The bricks of a slab.
    pub(super) const fn slab(&self, slab: usize) -> std::ops::Range<usize> {
        self.firsts[slab]..self.firsts[slab + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trainer::pack;

    #[test]
    fn bricks_around_a_cell_and_back_from_a_model() {
        // Cell (3, 0, 1) of 8 a side covers voxels 6 and 7 along x of 16: corners 6 to 8.
        let (coarse, fine) = pack(8, std::iter::once(3 + 64)).unwrap();
        let cells = Occupancy::new(8, 1, &coarse, &fine).unwrap();
        let bricks = Bricks::around(&cells, 16).unwrap();
        let places: Vec<_> = bricks.places().flatten().collect();
        // Along y corners 0 to 2, along z 2 to 4.
        assert_eq!(places, [[1, 0, 0], [2, 0, 0], [1, 0, 1], [2, 0, 1]]);
        assert_eq!((bricks.len(), bricks.row_of([7, 1, 3])), (5, Some(64 + 3 + 4 + 48)));
        assert_eq!((bricks.row_of([0; 3]), bricks.row_of([8, 0, 4])), (None, Some(4 * 64)));
        let bytes: Vec<u8> = bricks.numbers().iter().flat_map(|n| n.to_le_bytes()).collect();
        assert_eq!(Bricks::read(&bytes, 16, 5).as_ref(), Some(&bricks));
        assert_eq!((Bricks::read(&bytes, 16, 6), Bricks::read(&bytes, 20, 5)), (None, None));
        let mut twice = bytes.clone();
        twice[0] = 1;
        assert_eq!(Bricks::read(&twice, 16, 6), None);
    }

    #[test]
    fn rows_beside_a_row_are_those_of_corners_beside_it() {
        let (coarse, fine) = pack(8, [0, 1, 8, 9, 64, 65, 146].into_iter()).unwrap();
        let cells = Occupancy::new(8, 1, &coarse, &fine).unwrap();
        let bricks = Bricks::around(&cells, 16).unwrap();
        let corner = |i: u32| [i % 20, i / 20 % 20, i / 400];
        let mut lonely = 0;
        for corner in (0..8000).map(corner) {
            let Some(row) = bricks.row_of(corner) else { continue };
            for axis in 0..3 {
                let beside = |by: u32| {
                    let mut corner = corner;
                    corner[axis] = corner[axis].wrapping_add(by);
                    (corner[axis] < 20).then(|| bricks.row_of(corner)).flatten()
                };
                let expected = [beside(u32::MAX), beside(1)];
                assert_eq!(bricks.rows_beside(row, axis), expected, "{corner:?} {axis}");
                lonely += usize::from(expected.contains(&None));
            }
        }
        assert!(lonely > 100);
    }

    #[test]
    fn every_brick_is_in_the_slab_of_its_layer() {
        for resolution in [4, 16, 64] {
            let bricks = Bricks::all(resolution);
            assert_eq!(bricks.slab(0).start, 1);
            assert_eq!(bricks.slab(SLABS - 1).end, bricks.len());
            for (number, place) in bricks.places().enumerate() {
                let Some(place) = place else { continue };
                let slab = bricks.slab(bricks.slab_of_layer(place[2] as usize));
                assert!(slab.contains(&number), "{resolution}: {number} {place:?} {slab:?}");
            }
        }
    }
}
