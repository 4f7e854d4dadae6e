//! The shape of a hash grid: levels, and how corners are numbered.

use crate::{Error, TensorView};

/// Most levels a grid may have.
pub const MAX_LEVELS: usize = 16;
/// Most features an entry may have.
pub const MAX_FEATURES_PER_LEVEL: usize = 8;

/// How a corner's coordinates become the number of its entry.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridIndex {
    /// 2×2×2 corners lie together, so that a cell's eight corners touch 3.4
    /// runs of memory on average instead of eight. With block coordinates
    /// `b = c >> 1` and low bits `l = c & 1`, the entry is
    /// `8 * block + l.x + 2 l.y + 4 l.z`; `block` is `b.x + n (b.y + n b.z)`
    /// with `n = resolution / 2 + 1` on a level that fits the table (dense), else
    /// `(b.x ^ b.y * 2654435761 ^ b.z * 805459861) mod 2^(log2_hashmap_size - 3)`.
    #[default]
    Blocked,
}

/// Multipliers of the spatial hash (Teschner et al. 2003), x first.
pub const HASH_PRIMES: [u32; 3] = [1, 2_654_435_761, 805_459_861];

/// The shape of a hash grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HashGridConfig {
    /// Levels, 1 to [`MAX_LEVELS`].
    pub n_levels: u32,
    /// Values an entry: 1, 2, 4 or 8.
    pub n_features_per_level: u32,
    /// Base-two logarithm of the most entries a level may have: 3 to 24.
    pub log2_hashmap_size: u32,
    /// Resolution of level 0.
    pub base_resolution: u32,
    /// Growth of the resolution from level to level.
    pub per_level_scale: f32,
    /// Numbering of entries.
    pub index: GridIndex,
}

/// What a kernel needs to know of one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Cells along a unit length.
    pub scale: f32,
    /// Corners along an axis, `ceil(scale) + 1`.
    pub resolution: u32,
    /// Entries in the table.
    pub entries: u32,
    /// Blocks along an axis where the level is dense, 0 where it is hashed.
    pub dense_blocks: u32,
}

impl HashGridConfig {
    /// Values that the encoding gives for a point.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        (self.n_levels * self.n_features_per_level) as usize
    }

    /// Scale, resolution and table size of level `level`.
    #[must_use]
    pub fn level(&self, level: usize) -> Level {
        let mut resolution = f64::from(self.base_resolution);
        for _ in 0..level {
            resolution *= f64::from(self.per_level_scale);
        }
        let scale = (resolution - 1.0) as f32;
        let floor = scale as u32;
        let resolution = floor + u32::from(scale > floor as f32) + 1;
        let blocks = resolution / 2 + 1;
        let dense_entries = 8 * u64::from(blocks) * u64::from(blocks) * u64::from(blocks);
        let table = 1u64 << self.log2_hashmap_size;
        if dense_entries <= table {
            Level { scale, resolution, entries: dense_entries as u32, dense_blocks: blocks }
        } else {
            Level { scale, resolution, entries: table as u32, dense_blocks: 0 }
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        if !(1..=MAX_LEVELS as u32).contains(&self.n_levels) {
            return Err(Error::Range("hash grid n_levels"));
        }
        if !matches!(self.n_features_per_level, 1 | 2 | 4 | 8) {
            return Err(Error::Range("hash grid n_features_per_level"));
        }
        if !(3..=24).contains(&self.log2_hashmap_size) {
            return Err(Error::Range("hash grid log2_hashmap_size"));
        }
        if !(2..=1 << 16).contains(&self.base_resolution) {
            return Err(Error::Range("hash grid base_resolution"));
        }
        if !(self.per_level_scale.is_finite() && (1.0..=4.0).contains(&self.per_level_scale)) {
            return Err(Error::Range("hash grid per_level_scale"));
        }
        // Corner coordinates must stay exact in f32.
        if self.level(self.n_levels as usize - 1).scale > (1u32 << 20) as f32 {
            return Err(Error::Range("hash grid finest resolution"));
        }
        Ok(())
    }
}

/// A hash grid with its tables.
#[derive(Clone, Copy, Debug)]
pub struct HashGrid<'a> {
    /// Its shape.
    pub config: HashGridConfig,
    /// One tensor `[entries, n_features_per_level]` a level; the rest are empty.
    pub levels: [TensorView<'a>; MAX_LEVELS],
}

impl HashGrid<'_> {
    /// Checks the configuration and the size of every table.
    ///
    /// # Errors
    /// [`Error::Range`] or [`Error::Shape`].
    pub fn validate(&self) -> Result<(), Error> {
        self.config.validate()?;
        let n_levels = self.config.n_levels as usize;
        for (l, table) in self.levels.iter().enumerate().take(n_levels) {
            let level = self.config.level(l);
            if table.shape() != [level.entries, self.config.n_features_per_level]
                || table.dtype() != self.levels[0].dtype()
            {
                return Err(Error::Shape("hash grid: a level's table and the configuration"));
            }
        }
        Ok(())
    }
}
