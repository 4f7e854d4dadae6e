//! The occupancy grids of other programs: nested cubes with equal numbers of cells.

use core::iter::successors;
use core::ops::Range;
use std::vec;
use std::vec::Vec;

/// The occupied cells of cubes around the middle of a box. Each cube is as wide as the one
/// in it, twice; a point belongs to the smallest that it is in.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Cells along a side.
    side: usize,
    /// Half sides of the cubes, the box's longest side being 1.
    halves: Vec<f32>,
    /// A bit for each cell of each cube, `x + side (y + side z)`, eight in a byte.
    occupied: Vec<Vec<u8>>,
}

impl Cells {
    /// `is_occupied` takes a cube and a cell's number; in Morton order, `side` is a power of
    /// two.
    pub(super) fn new(
        side: usize,
        order: Order,
        halves: Vec<f32>,
        is_occupied: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let cells = side * side * side;
        let cube = |cube: usize| {
            let mut bits = vec![0; cells.div_ceil(8)];
            for cell in 0..cells {
                let [x, y, z] = [cell % side, cell / side % side, cell / (side * side)];
                let number = match order {
                    Order::Morton => spread(x) | spread(y) << 1 | spread(z) << 2,
                    Order::LastFirst => z + side * (y + side * x),
                };
                bits[cell / 8] |= u8::from(is_occupied(cube, number)) << (cell % 8);
            }
            bits
        };
        let occupied = (0..halves.len()).map(cube).collect();
        Self { side, halves, occupied }
    }

    /// Of cubes whose cells are a bit each, the lowest of a byte first; `None` where they
    /// are not so many.
    pub(super) fn of_bits(order: Order, halves: Vec<f32>, bytes: &[u8]) -> Option<Self> {
        let cells = 8 * bytes.len() / halves.len().max(1);
        let side = (1..=MOST).find(|side| side * side * side >= cells)?;
        if side * side * side * halves.len() != 8 * bytes.len()
            || order == Order::Morton && !side.is_power_of_two()
        {
            return None;
        }
        let is_occupied = |cube: usize, number: usize| {
            let bit = cube * cells + number;
            bytes[bit / 8] >> (bit % 8) & 1 == 1
        };
        Some(Self::new(side, order, halves, is_occupied))
    }

    /// Cells along the box's longest side, were all of them as small as the smallest.
    #[must_use]
    pub fn finest(&self) -> u32 {
        let smallest = self.halves.first().map_or(0.5, |half| 2.0 * half);
        (self.side as f32 / smallest).round() as u32
    }

    /// The occupied cells, `x + n (y + n z)` in ascending order, of a grid of n cells along
    /// the box's longest side: those that touch an occupied cell.
    pub fn on_grid(&self, n: u32) -> impl Iterator<Item = u32> + use<> {
        let n = n as usize;
        let mut bits = vec![0u64; (n * n * n).div_ceil(64)];
        let mut inner = 0..0;
        for (half, occupied) in self.halves.iter().zip(&self.occupied) {
            let ranges: Vec<_> = (0..self.side).map(|i| self.range(*half, i, n)).collect();
            let cells = 0..self.side * self.side * self.side;
            let set = cells.filter(|cell| occupied[cell / 8] >> (cell % 8) & 1 == 1);
            for cell in set {
                let s = self.side;
                let [xs, ys, zs] = [cell % s, cell / s % s, cell / (s * s)].map(|i| &ranges[i]);
                for z in zs.clone() {
                    for y in ys.clone() {
                        for x in xs.clone() {
                            // What is in the cube before is that one's.
                            if ![x, y, z].iter().all(|i| inner.contains(i)) {
                                let at = x + n * (y + n * z);
                                bits[at / 64] |= 1 << (at % 64);
                            }
                        }
                    }
                }
            }
            let size = n as f32;
            let begin = ((0.5 - half) * size - SLACK).ceil().max(0.0) as usize;
            inner = begin..((0.5 + half) * size + SLACK).floor() as usize;
        }
        let words = bits.into_iter().enumerate().filter(|(_, word)| *word != 0);
        words.flat_map(|(i, word)| {
            // Without the lowest bit, until none is left.
            let rest = |word: &u64| Some(word & (word - 1)).filter(|rest| *rest != 0);
            successors(Some(word), rest).map(move |word| 64 * i as u32 + word.trailing_zeros())
        })
    }

    /// What cell `i` along a side of a cube touches.
    fn range(&self, half: f32, i: usize, n: usize) -> Range<usize> {
        let size = n as f32;
        let face = |i: usize| (0.5 - half + 2.0 * half * i as f32 / self.side as f32) * size;
        let begin = (face(i) + SLACK).floor().max(0.0) as usize;
        begin..((face(i + 1) - SLACK).ceil().max(0.0) as usize).min(n)
    }
}

/// Most cells along a side.
const MOST: usize = 512;

/// In which order a program keeps the cells of a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// The coordinates' bits in turn, x in the lowest.
    Morton,
    /// `z + side (y + side x)`.
    LastFirst,
}

/// Faces that are nearer than this part of a cell are the same.
const SLACK: f32 = 1e-2;

/// Every bit of a coordinate in one of three places.
fn spread(coordinate: usize) -> usize {
    (0..10).fold(0, |code, bit| code | (coordinate >> bit & 1) << (3 * bit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_cubes_on_one_grid() {
        // Two cells a side: the inner cube's (1, 0, 0) and the outer one's (0, 1, 1).
        let occupied = |cube, cell| [1, 6][cube] == cell;
        let cells = Cells::new(2, Order::Morton, vec![0.25, 0.5], occupied);
        assert_eq!(cells.finest(), 4);
        // Of four along a side, the inner cube has 1 and 2. Its cell is (2, 1, 1). The outer
        // one's are x in 0 and 1, y and z in 2 and 3, without the inner cube's (1, 2, 2).
        let at = |x: u32, y: u32, z: u32| x + 4 * (y + 4 * z);
        let mut expected = vec![at(2, 1, 1)];
        for (z, y, x) in
            [(2, 2, 0), (2, 3, 0), (2, 3, 1), (3, 2, 0), (3, 2, 1), (3, 3, 0), (3, 3, 1)]
        {
            expected.push(at(x, y, z));
        }
        expected.sort_unstable();
        assert!(cells.on_grid(4).eq(expected));
        // Twice as fine: eight times as many. Half as fine: those touched.
        assert_eq!(cells.on_grid(8).count(), 8 * 8);
        assert!(cells.on_grid(2).eq([1, 6]));
    }

    #[test]
    fn a_bit_a_cell() {
        let (morton, last_first) = (Order::Morton, Order::LastFirst);
        // Two cells a side: bit 1 is x in Morton's order, z in the other.
        let of = |order, bytes: &[u8]| Cells::of_bits(order, vec![0.5], bytes);
        assert!(of(morton, &[2]).unwrap().on_grid(2).eq([1]));
        assert!(of(last_first, &[2]).unwrap().on_grid(2).eq([4]));
        for bytes in [&[][..], &[0; 2], &[0; 27], &[0; 5]] {
            assert!(of(morton, bytes).is_none(), "{} bytes", bytes.len());
        }
        assert!(of(last_first, &[0; 27]).is_some(), "six cells a side");
    }
}
