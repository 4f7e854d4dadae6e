//! Models to build of the kinds beside hash grids.

use pocketnerf_core::DType;
use pocketnerf_core::field::Shading;

use crate::models::{Encoding, Recipe};
use crate::nerf::Nerf;

impl Recipe {
    /// Those of grids of voxels, with each number of harmonics.
    pub(crate) fn voxels() -> impl Iterator<Item = Self> {
        (0..9).map(|n| Self {
            encoding: Encoding::Voxels([4, 12, 20][n % 3]),
            dtype: [DType::F32, DType::F16, DType::I8][n / 3],
            sh_degree: 1 + (n as u32 + 1) % 3,
            occupancy: [None, Some(16), Some(24)][(n + n / 3) % 3],
            seed: 4000 + n as u64,
            ..Self::PLAIN
        })
    }

    /// Those of vanilla NeRFs.
    pub(crate) fn nerfs() -> impl Iterator<Item = Self> {
        (0..2 * Nerf::ALL.len()).map(|n| Self {
            encoding: Encoding::Nerf(Nerf::ALL[n / 2]),
            dtype: if n & 1 == 0 { DType::F32 } else { DType::F16 },
            occupancy: [None, Some(16), Some(24)][n % 3],
            seed: 3000 + n as u64,
            ..Self::PLAIN
        })
    }

    /// Those of planes, with every stored type and every shading.
    pub(crate) fn planes() -> impl Iterator<Item = Self> {
        (0..12).map(|n| Self {
            encoding: Encoding::Planes([16, 32][n % 2]),
            dtype: [DType::F32, DType::F16, DType::I8][n % 3],
            shading: if n < 6 { Shading::PerSample } else { Shading::PerRay },
            sh_degree: 1 + n as u32 % 4,
            occupancy: [None, Some(16), Some(24)][n / 2 % 3],
            seed: 5000 + n as u64,
        })
    }

    /// Those of decomposed fields, with and without directions.
    pub(crate) fn derfs() -> impl Iterator<Item = Self> {
        (0..8).map(|n| Self {
            encoding: Encoding::Derf([1, 3, 8, 64][n % 4]),
            dtype: [DType::F32, DType::F16][n / 4],
            sh_degree: 1 + (n as u32 + n as u32 / 4) % 2,
            occupancy: [None, Some(16), Some(24)][n % 3],
            seed: 6000 + n as u64,
            ..Self::PLAIN
        })
    }
}
