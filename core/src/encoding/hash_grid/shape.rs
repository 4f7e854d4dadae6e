//! The shape of a hash grid: levels, and how corners are numbered.

use crate::{DType, Error, TensorView};

/// Most levels a grid may have.
pub const MAX_LEVELS: usize = 16;
/// Most features an entry may have.
pub const MAX_FEATURES_PER_LEVEL: usize = 8;

/// Whether this build links [`GridIndex::Corners`].
const CORNER_INDEX: bool = cfg!(feature = "corner-index");

/// How a corner's coordinates become the number of its entry.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GridIndex {
    /// 2×2×2 corners lie together, so that a cell's eight corners touch 3.4
    /// runs of memory on average instead of eight. With block coordinates
    /// `b = c >> 1` and low bits `l = c & 1`, the entry is
    /// `8 * block + l.x + 2 l.y + 4 l.z`; `block` is `b.x + n (b.y + n b.z)`
    /// with `n = resolution / 2 + 1` on a level that fits the table (dense), else
    /// `(b.x ^ b.y * 2654435761 ^ b.z * 805459861) mod 2^(log2_hashmap_size - 3)`.
    #[default]
    Blocked,
    /// Corner by corner, as tiny-cuda-nn and its kin do: `c.x + side (c.y + side c.z)`
    /// on a dense level, `c.x ^ c.y * 2654435761 ^ c.z * 805459861` on a hashed one,
    /// both modulo the level's entries.
    Corners(CornerLevels),
}

/// Multipliers of the spatial hash (Teschner et al. 2003), x first.
pub const HASH_PRIMES: [u32; 3] = [1, 2_654_435_761, 805_459_861];

/// The levels of [`GridIndex::Corners`]. The programs that such grids come from round in
/// ways of their own, so scales and sizes are what they have them to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerLevels {
    /// Added to grid positions: 0.5, or 0 where the first corner is at u = 0.
    pub shift: f32,
    /// One a level; the rest are ignored.
    pub levels: [CornerLevel; MAX_LEVELS],
}

/// A level of [`CornerLevels`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CornerLevel {
    /// Cells along a unit length.
    pub scale: f32,
    /// Entries from one corner to the next along y where the level is dense; 0 where it
    /// is hashed.
    pub side: u32,
    /// Entries in the table; a power of two where the level is hashed.
    pub entries: u32,
}

impl CornerLevel {
    /// Whether every corner that a point can have is in the table, less than twice around
    /// on a dense level.
    fn is_sound(&self, shift: f32, log2_hashmap_size: u32) -> bool {
        let Self { scale, side, entries } = *self;
        // Corner coordinates must stay exact in f32.
        if !(0.0..=(1u32 << 20) as f32).contains(&scale) || entries > 1 << log2_hashmap_size {
            return false;
        }
        let last = (scale + shift) as u32 + 1;
        match u64::from(side) {
            0 => entries.is_power_of_two(),
            // s (1 + s + s s) < 2 s s s for s > 1.
            side => side > 1 && side >= last.into() && side.pow(3) <= entries.into(),
        }
    }
}

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
    /// Numbering of entries. Where it lists the levels, base resolution and growth are
    /// only what they came from.
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
    /// Blocks along an axis where the level is dense, 0 where it is hashed. Corners
    /// instead of blocks where they are numbered one by one.
    pub dense_side: u32,
    /// Added to grid positions, of corners that are numbered one by one.
    pub corner_shift: Option<f32>,
}

impl Level {
    /// Whether corners are numbered one by one, not in blocks.
    #[must_use]
    pub const fn is_by_corner(&self) -> bool {
        CORNER_INDEX && self.corner_shift.is_some()
    }

    /// Added to `u * scale` for the grid position.
    #[must_use]
    pub const fn shift(&self) -> f32 {
        match self.corner_shift {
            Some(shift) if CORNER_INDEX => shift,
            _ => 0.5,
        }
    }
}

impl HashGridConfig {
    /// Values of an encoded point.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        (self.n_levels * self.n_features_per_level) as usize
    }

    /// Scale, resolution and table size of level `level`.
    #[must_use]
    pub fn level(&self, level: usize) -> Level {
        if let (true, GridIndex::Corners(corners)) = (CORNER_INDEX, &self.index) {
            let CornerLevels { shift, levels } = corners;
            let CornerLevel { scale, side, entries } = levels[level];
            let resolution = scale as u32 + u32::from(scale > (scale as u32) as f32) + 1;
            let corner_shift = Some(*shift);
            return Level { scale, resolution, entries, dense_side: side, corner_shift };
        }
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
        let (entries, dense_side) =
            if dense_entries <= table { (dense_entries, blocks) } else { (table, 0) };
        Level { scale, resolution, entries: entries as u32, dense_side, corner_shift: None }
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
        if let GridIndex::Corners(CornerLevels { shift, levels }) = &self.index {
            if !CORNER_INDEX {
                return Err(Error::Feature("corner-index"));
            }
            let levels = &levels[..self.n_levels as usize];
            if !(0.0..=1.0).contains(shift) {
                return Err(Error::Range("hash grid shift"));
            }
            if !levels.iter().all(|level| level.is_sound(*shift, self.log2_hashmap_size)) {
                return Err(Error::Range("hash grid level's scale, side or entries"));
            }
            return Ok(());
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
                || table.dtype() == DType::U16
            {
                return Err(Error::Shape("hash grid: a level's table and the configuration"));
            }
        }
        Ok(())
    }
}
