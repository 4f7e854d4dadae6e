//! How a position or a direction becomes the numbers a network reads.

#[cfg(feature = "nerf")]
pub mod fourier;
pub mod hash_grid;
pub mod spherical_harmonics;

#[cfg(feature = "nerf")]
pub use fourier::{Affine, Fourier, Waves};
#[cfg(feature = "corner-index")]
pub use hash_grid::{CornerLevel, CornerLevels};
pub use hash_grid::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
