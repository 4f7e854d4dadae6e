//! Corners of voxels that no occupied cell reaches.

use alloc::vec;
use alloc::vec::Vec;

use pocketnerf_core::Occupancy;
use pocketnerf_core::encoding::VoxelGrid;
use pocketnerf_core::encoding::voxel_grid::{BRICK, bricks_along};

use super::unused::{corners, each_reached};

/// Which rows of values are read by points in occupied cells, and as far beyond them as gradients
/// reach, unit coordinates.
pub(super) fn used(occupancy: &Occupancy<'_>, grid: &VoxelGrid<'_>, beyond: f32) -> Vec<bool> {
    let (n, scale) = (occupancy.resolution(), grid.resolution as f32);
    let reach = |cell: u32| {
        let [first, last] = corners(cell, n, [scale, 0.0], beyond);
        first..=last.min(grid.resolution + 1)
    };
    let along = bricks_along(grid.resolution);
    let n_bricks = grid.values.rows() / BRICK;
    let mut used = vec![false; grid.values.rows()];
    let mark = |[x, y, z]: [u32; 3]| {
        let place = x / 4 + along * (y / 4 + along * (z / 4));
        let number = (grid.index.get(place as usize) as usize).min(n_bricks - 1);
        used[BRICK * number + (x % 4 + 4 * (y % 4) + 16 * (z % 4)) as usize] = true;
    };
    each_reached(occupancy, reach, mark);
    used
}
