//! A hash grid as core has it, from levels and one list of all entries.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::encoding::{
    CornerLevel, CornerLevels, GridIndex, HashGrid, HashGridConfig, MAX_LEVELS,
};
use pocketnerf_core::{DType, Error, Layout, TensorView};

use crate::import::settings::setting;
use crate::import::{FieldError, Tensor};

/// A hash grid in memory of its own.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    config: HashGridConfig,
    /// f32, one level after another.
    bytes: Vec<u8>,
}

/// How a program sizes its levels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) n_levels: u32,
    pub(super) n_features: u32,
    pub(super) base_resolution: u32,
    pub(super) per_level_scale: f32,
    /// Added to grid positions.
    pub(super) shift: f32,
}

impl Grid {
    /// `table` holds the features of one entry after another, level after level.
    pub(super) fn new(
        shape: Shape,
        levels: &[CornerLevel],
        (name, table): (&str, &Tensor<'_>),
    ) -> Result<Self, FieldError> {
        let n_features = shape.n_features as usize;
        let entries: usize = levels.iter().map(|level| level.entries as usize).sum();
        if entries * n_features != table.len() {
            let expected = format!("{} of {} entries", entries * n_features, entries);
            return Err(setting(name, &format!("{} values in tables", table.len()), &expected));
        }
        let mut all = [CornerLevel::default(); MAX_LEVELS];
        all.iter_mut().zip(levels).for_each(|(to, level)| *to = *level);
        let most = levels.iter().map(|level| level.entries).max().unwrap_or_default().max(8);
        let config = HashGridConfig {
            n_levels: shape.n_levels,
            n_features_per_level: shape.n_features,
            log2_hashmap_size: most.next_power_of_two().ilog2(),
            base_resolution: shape.base_resolution,
            per_level_scale: shape.per_level_scale,
            index: GridIndex::Corners(CornerLevels { shift: shape.shift, levels: all }),
        };
        let problem = |error: Error| setting("the hash grid", &error.to_string(), "one in range");
        config.validate().map_err(problem)?;
        let bytes = table.to_f32_bytes();
        let bytes = bytes.map_err(|error| FieldError::Tensor(name.to_string(), error))?;
        let mut values = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        match values.all(f32::is_finite) {
            true => Ok(Self { config, bytes }),
            false => Err(FieldError::NotFinite(name.to_string())),
        }
    }

    /// For core.
    pub(super) fn view(&self) -> Result<HashGrid<'_>, Error> {
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        let n_features = self.config.n_features_per_level;
        let mut rest = &self.bytes[..];
        for (l, to) in levels.iter_mut().enumerate().take(self.config.n_levels as usize) {
            let entries = self.config.level(l).entries;
            let (bytes, after) = rest.split_at(4 * entries as usize * n_features as usize);
            *to = TensorView::new(bytes, DType::F32, [entries, n_features], 0, Layout::RowMajor)?;
            rest = after;
        }
        Ok(HashGrid { config: self.config, levels })
    }
}
