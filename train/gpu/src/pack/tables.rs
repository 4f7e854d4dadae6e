//! The tables of a hash grid, in whole words.

use alloc::vec::Vec;

use pocketnerf_core::DType;
use pocketnerf_core::encoding::{HashGrid, hash_grid::Level};

/// A level's table in the buffer of tables.
#[derive(Debug)]
pub(crate) struct PackedLevel {
    pub(crate) level: Level,
    /// The number of its first value.
    pub(crate) first: usize,
    /// What its values are multiplied by.
    pub(crate) factor: f32,
}

/// Appends the tables, which have one type, to `words`.
pub(super) fn pack(grid: &HashGrid<'_>, words: &mut Vec<u32>) -> Vec<PackedLevel> {
    let n_levels = grid.config.n_levels as usize;
    let mut levels = Vec::new();
    for (l, table) in grid.levels.iter().enumerate().take(n_levels) {
        let per_word = size_of::<u32>() / table.dtype().size();
        let first = words.len() * per_word;
        for bytes in table.bytes().chunks(size_of::<u32>()) {
            let mut word = [0; 4];
            word[..bytes.len()].copy_from_slice(bytes);
            words.push(u32::from_le_bytes(word));
        }
        levels.push(PackedLevel { level: grid.config.level(l), first, factor: table.scale() });
    }
    levels
}

/// The file of the shader that reads such tables.
pub(crate) const fn reader(dtype: DType) -> Option<&'static str> {
    match dtype {
        DType::F32 => Some(wgsl!("stored_f32")),
        DType::F16 => Some(wgsl!("stored_f16")),
        DType::I8 => Some(wgsl!("stored_i8")),
        _ => None,
    }
}
