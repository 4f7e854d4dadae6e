//! How a position or a direction becomes the numbers a network reads.

pub mod frequency;
pub mod hash_grid;
pub mod spherical_harmonics;

pub use frequency::FrequencyConfig;
pub use hash_grid::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
