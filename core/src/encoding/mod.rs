//! How a position or a direction becomes the numbers a network reads.

pub mod fourier;
pub mod hash_grid;
#[cfg(feature = "planes")]
pub mod planes;
pub mod spherical_harmonics;
#[cfg(feature = "plenoxels")]
pub mod voxel_grid;

pub use fourier::{Affine, Fourier, Waves};
pub use hash_grid::{CornerLevel, CornerLevels};
pub use hash_grid::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
#[cfg(feature = "planes")]
pub use planes::Planes;
#[cfg(feature = "plenoxels")]
pub use voxel_grid::VoxelGrid;
