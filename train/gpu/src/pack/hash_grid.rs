//! A hash grid's levels.

use alloc::vec::Vec;

use pocketnerf_core::encoding::{HashGrid, hash_grid::Level};

use super::tables::push;

#[derive(Debug, Default)]
pub(crate) struct PackedGrid {
    /// Values of an entry.
    pub(crate) n_features_per_level: usize,
    pub(crate) by_corner: bool,
    pub(crate) levels: Vec<PackedLevel>,
}

/// A level's table in the buffer of tables.
#[derive(Debug)]
pub(crate) struct PackedLevel {
    pub(crate) level: Level,
    /// The number of its first value.
    pub(crate) first: usize,
    /// What its values are multiplied by.
    pub(crate) factor: f32,
}

/// Appends the tables to `words`.
pub(super) fn pack(grid: &HashGrid<'_>, words: &mut Vec<u32>) -> PackedGrid {
    let n_levels = grid.config.n_levels as usize;
    let mut levels = Vec::new();
    for (l, table) in grid.levels.iter().enumerate().take(n_levels) {
        let level = grid.config.level(l);
        levels.push(PackedLevel { level, first: push(table, words), factor: table.scale() });
    }
    PackedGrid {
        n_features_per_level: grid.config.n_features_per_level as usize,
        by_corner: grid.config.level(0).is_by_corner(),
        levels,
    }
}
