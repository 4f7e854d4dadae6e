//! Entries of planes and lines that no occupied cell reaches.

use alloc::vec;
use alloc::vec::Vec;

use pocketnerf_core::Occupancy;
use pocketnerf_core::encoding::Planes;
use pocketnerf_core::encoding::planes::ACROSS;

use super::unused::corners;

/// Which entries of a table are read by points in occupied cells, and as far beyond them as
/// gradients reach, unit coordinates. Tables are numbered as in the file: planes are even.
pub(super) fn used(
    occupancy: &Occupancy<'_>,
    planes: &Planes<'_>,
    table: usize,
    beyond: f32,
) -> Vec<bool> {
    let (n, resolution) = (occupancy.resolution(), planes.resolution);
    let reach = |cell: u32| {
        let [first, last] = corners(cell, n, [(resolution - 1) as f32, 0.0], beyond);
        first.min(resolution - 2)..=last.min(resolution - 1)
    };
    let axis = Planes::axis(planes.n_components, table / 2);
    let [first, second] = ACROSS[axis];
    let is_line = table % 2 == 1;
    // Cells seen along the axis, or across it.
    let mut seen = vec![false; if is_line { n } else { n * n } as usize];
    for z in 0..n {
        for y in 0..n {
            for x in (0..n).filter(|x| occupancy.cell(*x, y, z)) {
                let cell = [x, y, z];
                let place = if is_line { cell[axis] } else { cell[first] + n * cell[second] };
                seen[place as usize] = true;
            }
        }
    }
    let entries = if is_line { resolution } else { resolution * resolution };
    let mut used = vec![false; entries as usize];
    for (place, _) in (0..).zip(&seen).filter(|(_, seen)| **seen) {
        for entry in reach(place % n) {
            if is_line {
                used[entry as usize] = true;
                continue;
            }
            reach(place / n).for_each(|row| used[(entry + resolution * row) as usize] = true);
        }
    }
    used
}
