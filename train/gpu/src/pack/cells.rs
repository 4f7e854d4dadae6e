//! Occupied cells, and how far it is to them.

use alloc::vec::Vec;

use pocketnerf_core::Occupancy;
use pocketnerf_core::occupancy::BLOCK;

/// Marks a block without occupied cells.
const EMPTY: u32 = 1 << 31;
/// Words of a block's bits, one a cell.
const WORDS: usize = 16;

/// See [`Packed::occupancy`](super::Packed::occupancy); empty where everything is occupied.
pub(crate) fn pack(occupancy: Option<&Occupancy<'_>>) -> Vec<u32> {
    let Some(occupancy) = occupancy else { return Vec::new() };
    let n = occupancy.resolution() / BLOCK;
    let (mut blocks, mut cells) = (Vec::new(), Vec::new());
    for number in 0..n * n * n {
        let [x, y, z] = place(number, n);
        match occupancy.block(x, y, z) {
            Some(bits) => {
                blocks.push((cells.len() / WORDS) as u32);
                let (words, _) = bits.as_chunks::<4>();
                words.iter().for_each(|bytes| cells.push(u32::from_le_bytes(*bytes)));
            }
            None => blocks.push(EMPTY | BLOCK),
        }
    }
    grow(&mut blocks, n);
    blocks.extend(cells);
    blocks
}

/// Notes of each empty block the side of the largest empty cube that it is a part of. Cubes
/// have 2, 4, 8 and so on blocks along a side, and begin at multiples of it.
fn grow(blocks: &mut [u32], n: u32) {
    let mut side = 2;
    while side <= n {
        // Those that are as large as they can be so far.
        let (half, whole) = (EMPTY | (BLOCK * side / 2), EMPTY | (BLOCK * side));
        let cubes = n / side;
        for cube in 0..cubes * cubes * cubes {
            let corner = place(cube, cubes);
            let blocks_of = (0..side * side * side).map(|i| {
                let [x, y, z] = place(i, side);
                let [x, y, z] = [x + side * corner[0], y + side * corner[1], z + side * corner[2]];
                (x + n * (y + n * z)) as usize
            });
            if blocks_of.clone().all(|block| blocks[block] == half) {
                blocks_of.for_each(|block| blocks[block] = whole);
            }
        }
        side *= 2;
    }
}

/// Where the block of this number is, in a cube of blocks with this side.
const fn place(number: u32, side: u32) -> [u32; 3] {
    [number % side, number / side % side, number / (side * side)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_and_what_is_around_it_by_hand() {
        // 6^3 blocks, of which block (5, 0, 0) has one cell, (2, 3, 1) within it.
        let mut coarse = vec![0; 2 * 216];
        coarse[10] = 1;
        let mut fine = [0; 64];
        fine[3 + 8] = 1 << 2;
        let occupancy = Occupancy::new(48, 1, &coarse, &fine).unwrap();
        let packed = pack(Some(&occupancy));
        assert_eq!(packed.len(), 216 + 16);
        let at = |x: usize, y: usize, z: usize| packed[x + 6 * (y + 6 * z)];
        assert_eq!(at(5, 0, 0), 0);
        // Its neighbours in a cube of 2^3 blocks are alone; cubes of 4^3 blocks fit once.
        assert_eq!((at(4, 0, 0), at(5, 1, 1)), (EMPTY | 8, EMPTY | 8));
        assert_eq!((at(4, 2, 0), at(5, 5, 5)), (EMPTY | 16, EMPTY | 16));
        assert_eq!((at(0, 0, 0), at(3, 3, 3), at(3, 4, 3)), (EMPTY | 32, EMPTY | 32, EMPTY | 16));
        // Bit x + 8 y + 64 z = 2 + 24 + 64 = 90: word 2, bit 26.
        let mut bits = [0; 16];
        bits[2] = 1 << 26;
        assert_eq!(packed[216..], bits);
        assert_eq!(pack(None), [0; 0]);
    }
}
