//! Entries of hash tables that no occupied cell reaches.

use alloc::borrow::Cow;
use alloc::vec;

use pocketnerf_core::Occupancy;
use pocketnerf_core::encoding::hash_grid::{HASH_PRIMES, Level};
use pocketnerf_core::encoding::{GridIndex, HashGrid};
use pocketnerf_core::march::Reach;
use pocketnerf_core::query::gradient_spacing;

use crate::ModelFile;

/// Entries of a block.
const BLOCK: usize = 8;
/// Distance by which a point's place in a grid may be off by rounding, cells of the grid: at
/// least this, and on fine grids this share of their cells along an axis, four units of f32.
const SLACK: f32 = 0.01;
const RELATIVE_SLACK: f32 = 4.0 * f32::EPSILON;

/// The model's hash grid, where it has one.
pub(super) fn grid<'f, 'a>(file: &'f ModelFile<'a>) -> Option<&'f HashGrid<'a>> {
    match &file.model.field {
        #[cfg(feature = "hash-grid")]
        pocketnerf_core::AnyField::HashGrid(field) => Some(&field.grid),
        #[allow(unreachable_patterns, reason = "other kinds may be left out")]
        _ => None,
    }
}

/// A level's table in which blocks that no sample reads are 0.
pub(super) fn cleared<'a>(file: &ModelFile<'a>, level: usize, table: &'a [u8]) -> Cow<'a, [u8]> {
    let occupancy = file.model.occupancy.filter(|occupancy| occupancy.n_cascades() == 1);
    let Some(occupancy) = occupancy else { return table.into() };
    // Hierarchical samples may lie in empty cells.
    let reach = file.model.hierarchical.map(|hierarchical| hierarchical.reach);
    if reach.is_some_and(|reach| reach != Reach::Clipped) {
        return table.into();
    }
    #[cfg(feature = "plenoxels")]
    if let (pocketnerf_core::AnyField::Plenoxels(field), 0) = (&file.model.field, level) {
        let beyond = gradient_spacing(&file.model.field);
        let used = super::unused_voxels::used(&occupancy, &field.grid, beyond);
        return without(table, &used);
    }
    #[cfg(feature = "planes")]
    if let pocketnerf_core::AnyField::Planes(field) = &file.model.field {
        let beyond = gradient_spacing(&file.model.field);
        return without(
            table,
            &super::unused_planes::used(&occupancy, &field.planes, level, beyond),
        );
    }
    let Some(grid) = grid(file) else { return table.into() };
    // Other numberings are other programs'.
    if !matches!(grid.config.index, GridIndex::Blocked) {
        return table.into();
    }
    let shape = grid.config.level(level);
    let used = used(&occupancy, &shape, gradient_spacing(&file.model.field));
    without(table, &used)
}

/// A table in which blocks that are not used are 0.
fn without<'a>(table: &'a [u8], used: &[bool]) -> Cow<'a, [u8]> {
    let block_bytes = table.len() / used.len().max(1);
    let mut table = Cow::Borrowed(table);
    for (block, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
        let bytes = block * block_bytes..(block + 1) * block_bytes;
        if table[bytes.clone()].iter().any(|byte| *byte != 0) {
            table.to_mut()[bytes].fill(0);
        }
    }
    table
}

/// Which blocks of a level are read by points in occupied cells, and as far beyond them as
/// gradients reach, unit coordinates.
fn used(occupancy: &Occupancy<'_>, level: &Level, beyond: f32) -> vec::Vec<bool> {
    let n = occupancy.resolution();
    // On fine grids rounding reaches farther.
    let beyond = beyond + RELATIVE_SLACK;
    // The blocks of corners that the points of a cell lie between, along any axis.
    let reach = |cell: u32| {
        let [first, last] = corners(cell, n, [level.scale, level.shift()], beyond);
        first >> 1..(last >> 1) + 1
    };
    let mut used = vec![false; level.entries as usize / BLOCK];
    let mark = |[x, y, z]: [u32; 3]| {
        let block = match level.dense_side {
            0 => {
                let [x, y, z] =
                    [(x, 0), (y, 1), (z, 2)].map(|(c, a)| c.wrapping_mul(HASH_PRIMES[a]));
                (x ^ y ^ z) as usize & (used.len() - 1)
            }
            side => (x + side * (y + side * z)) as usize,
        };
        // Corners beyond the last are not read by points of the unit cube.
        if let Some(used) = used.get_mut(block) {
            *used = true;
        }
    };
    each_reached(occupancy, reach, mark);
    used
}

/// The first and the last corner that points of a cell, the one of `n` along an axis, lie between,
/// and points so far beyond it, unit coordinates: in a grid where they lie at `u * scale + shift`.
pub(super) fn corners(cell: u32, n: u32, [scale, shift]: [f32; 2], beyond: f32) -> [u32; 2] {
    let slack = SLACK + beyond * scale;
    let at = |cell: u32| cell as f32 / n as f32 * scale + shift;
    let (low, high) = (at(cell) - slack, at(cell + 1) + slack);
    [low.max(0.0) as u32, high as u32 + 1]
}

/// All places within the reach of an occupied cell along each axis.
pub(super) fn each_reached<R: Iterator<Item = u32>>(
    occupancy: &Occupancy<'_>,
    reach: impl Fn(u32) -> R,
    mut mark: impl FnMut([u32; 3]),
) {
    let n = occupancy.resolution();
    for z in 0..n {
        for y in 0..n {
            for x in (0..n).filter(|x| occupancy.cell(*x, y, z)) {
                for z in reach(z) {
                    for y in reach(y) {
                        reach(x).for_each(|x| mark([x, y, z]));
                    }
                }
            }
        }
    }
}
