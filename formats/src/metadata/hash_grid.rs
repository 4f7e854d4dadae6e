//! FIELD of a hash grid, before its decoder.

#[cfg(feature = "corner-index")]
use pocketnerf_core::encoding::{CornerLevel, CornerLevels, MAX_LEVELS};
use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;

/// Codes of [`GridIndex`].
const BLOCKED: u8 = 0;
#[cfg(feature = "corner-index")]
const CORNERS: u8 = 1;

/// The grid. Where its index is [`CORNERS`], the shift (`f32`) and a [`CornerLevelV1`] for
/// each level follow.
#[derive(Serialize, Deserialize)]
struct HashGridV1 {
    n_levels: u32,
    n_features_per_level: u32,
    log2_hashmap_size: u32,
    base_resolution: u32,
    per_level_scale: f32,
    index: u8,
}

#[cfg(feature = "corner-index")]
#[derive(Serialize, Deserialize)]
struct CornerLevelV1 {
    scale: f32,
    side: u32,
    entries: u32,
}

pub(super) fn read(fields: &mut Fields<'_>) -> Result<HashGridConfig, FormatError> {
    let grid: HashGridV1 = fields.take()?;
    fields.finite("per_level_scale", &[grid.per_level_scale])?;
    Ok(HashGridConfig {
        n_levels: grid.n_levels,
        n_features_per_level: grid.n_features_per_level,
        log2_hashmap_size: grid.log2_hashmap_size,
        base_resolution: grid.base_resolution,
        per_level_scale: grid.per_level_scale,
        index: match grid.index {
            BLOCKED => GridIndex::Blocked,
            #[cfg(feature = "corner-index")]
            CORNERS => GridIndex::Corners(read_corners(fields, grid.n_levels)?),
            code => return Err(fields.unknown("index of grid entries", code)),
        },
    })
}

#[cfg(feature = "corner-index")]
fn read_corners(fields: &mut Fields<'_>, n_levels: u32) -> Result<CornerLevels, FormatError> {
    let mut levels = [CornerLevel::default(); MAX_LEVELS];
    fields.check("n_levels", n_levels as usize <= MAX_LEVELS)?;
    let shift = fields.take()?;
    for level in &mut levels[..n_levels as usize] {
        let CornerLevelV1 { scale, side, entries } = fields.take()?;
        *level = CornerLevel { scale, side, entries };
    }
    Ok(CornerLevels { shift, levels })
}

/// `None` for an index that the format has no code for.
#[cfg(feature = "alloc")]
pub(super) fn write(grid: &HashGridConfig) -> Option<alloc::vec::Vec<u8>> {
    let index = match &grid.index {
        GridIndex::Blocked => BLOCKED,
        #[cfg(feature = "corner-index")]
        GridIndex::Corners(_) => CORNERS,
        _ => return None,
    };
    let bytes = super::encode(&HashGridV1 {
        n_levels: grid.n_levels,
        n_features_per_level: grid.n_features_per_level,
        log2_hashmap_size: grid.log2_hashmap_size,
        base_resolution: grid.base_resolution,
        per_level_scale: grid.per_level_scale,
        index,
    });
    #[cfg(feature = "corner-index")]
    let bytes = match &grid.index {
        GridIndex::Corners(corners) => {
            let levels = corners.levels.iter().take(grid.n_levels as usize);
            let level = |&CornerLevel { scale, side, entries }: &CornerLevel| {
                super::encode(&CornerLevelV1 { scale, side, entries })
            };
            let parts = [bytes, super::encode(&corners.shift)].into_iter();
            parts.chain(levels.map(level)).flatten().collect()
        }
        _ => bytes,
    };
    Some(bytes)
}
