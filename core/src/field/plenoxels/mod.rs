//! Plenoxels: a sparse grid of densities and spherical harmonics of colour, and no network.

mod reference;

use fearless_simd::{Simd, SimdBase, SimdFloat};

use crate::Error;
use crate::encoding::{VoxelGrid, spherical_harmonics, voxel_grid};
use crate::field::{Field, FieldKernels, MAX_SIGMA, Samples};
use crate::lanes;
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

/// A sparse grid of voxels (Fridovich-Keil et al. 2022).
///
/// Between its corners values are interpolated: value 0 is a multiple of the logarithm of the
/// density, `sigma = exp(min(DENSITY_GAIN * value + log_density_bias, 15))`; then come
/// `sh_degree²` harmonics of red, as many of green and of blue; what is left is not read. A
/// colour is `0.5 + Σ harmonic(direction) * value`, cut off at 0 and 1. Unlike in the paper,
/// densities are exponentials: surfaces are sharper than the grid (as in Sun et al. 2022, "Direct
/// voxel grid optimization", section 4.2).
#[derive(Clone, Copy, Debug)]
pub struct PlenoxelField<'a> {
    /// The grid, of [`n_values`](Self::n_values) a corner.
    pub grid: VoxelGrid<'a>,
    /// Degree of the spherical harmonics, 1 to 3; 1 is independent of the view.
    pub sh_degree: u32,
    /// Added to the log density; carries the unit of length.
    pub log_density_bias: f32,
}

impl PlenoxelField<'_> {
    /// What value 0 of a corner is multiplied by for the logarithm of the density. Densities vary
    /// by more powers of e than colours vary at all, and both are stored alike.
    pub const DENSITY_GAIN: f32 = 8.0;
    /// Highest degree of the harmonics: nine a colour.
    pub const MAX_SH_DEGREE: u32 = 3;

    /// Values of a corner: what is used of them and so many more that they fill whole registers.
    #[must_use]
    pub const fn n_values(sh_degree: u32) -> usize {
        (1 + 3 * spherical_harmonics::n_output(sh_degree)).next_power_of_two()
    }

    /// Harmonics of a colour.
    const fn n_harmonics(&self) -> usize {
        spherical_harmonics::n_output(self.sh_degree)
    }

    /// From value 0 in the first `n` of `work.a` to sigma in row 0 of `work.output`.
    #[inline(always)]
    fn densities<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        simd.vectorize(
            #[inline(always)]
            || {
                let lanes = work.a[..n].chunks_exact(S::f32s::LEN);
                let most = S::f32s::splat(simd, MAX_SIGMA);
                let bias = S::f32s::splat(simd, self.log_density_bias);
                for (from, to) in lanes.zip(work.output[..n].chunks_exact_mut(S::f32s::LEN)) {
                    let value = S::f32s::from_slice(simd, from);
                    let log = value.mul_add(S::f32s::splat(simd, Self::DENSITY_GAIN), bias);
                    // Cut off after `exp`, which takes NaN to 0.
                    lanes::exp(simd, log).min(most).store_slice(to);
                }
            },
        );
    }

    /// From the other rows of `work.a` to colours in rows 1 to 3 of `work.output`.
    #[inline(always)]
    fn colors<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        let (n_harmonics, stride) = (self.n_harmonics(), work.stride);
        simd.vectorize(
            #[inline(always)]
            || {
                let splat = |v: f32| S::f32s::splat(simd, v);
                let mut harmonics =
                    [splat(0.0); spherical_harmonics::n_output(Self::MAX_SH_DEGREE)];
                for first in (0..samples.len()).step_by(S::f32s::LEN) {
                    let load = |from: &[f32]| S::f32s::from_slice(simd, &from[..S::f32s::LEN]);
                    let direction = samples.directions.map(|axis| load(&axis[first..]));
                    spherical_harmonics::evaluate_each(
                        self.sh_degree,
                        direction,
                        splat(1.0),
                        &mut harmonics,
                    );
                    for color in 0..3 {
                        let mut sum = splat(0.5);
                        for (h, harmonic) in harmonics[..n_harmonics].iter().enumerate() {
                            let row = 1 + color * n_harmonics + h;
                            let value = load(&work.a[row * stride + first..]);
                            sum = value.mul_add(*harmonic, sum);
                        }
                        // max first: NaN is black.
                        let to = &mut work.output[(1 + color) * stride + first..];
                        let cut = sum.max_precise(0.0).min(splat(1.0));
                        cut.store_slice(&mut to[..S::f32s::LEN]);
                    }
                }
            },
        );
    }
}

impl Field for PlenoxelField<'_> {
    fn kind(&self) -> &'static str {
        "plenoxels"
    }

    fn channels(&self) -> usize {
        3
    }

    fn dtype(&self) -> DType {
        self.grid.values.dtype()
    }

    fn limits(&self) -> Limits {
        let n_values = self.grid.n_values();
        Limits { width: n_values, rows: [n_values, 0], channels: 3, ray_samples: 0 }
    }

    /// A voxel.
    fn finest_detail(&self) -> f32 {
        1.0 / self.grid.resolution as f32
    }

    fn validate(&self) -> Result<(), Error> {
        self.grid.validate()?;
        if !(1..=Self::MAX_SH_DEGREE).contains(&self.sh_degree) {
            return Err(Error::Range("degree of the spherical harmonics"));
        }
        if self.grid.n_values() != Self::n_values(self.sh_degree) {
            return Err(Error::Shape("voxel grid and the degree of the spherical harmonics"));
        }
        if self.log_density_bias.is_nan() || self.log_density_bias.abs() >= 64.0 {
            return Err(Error::Range("log density bias"));
        }
        Ok(())
    }
}

impl FieldKernels for PlenoxelField<'_> {
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        voxel_grid::interpolate(simd, &self.grid, points, work.a, work.stride);
    }

    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.densities(simd, samples.len(), work);
        self.colors(simd, samples, work);
    }

    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        self.densities(simd, n, work);
    }
}
