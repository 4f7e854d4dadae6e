//! The hash-grid field: grid, density network, colour network.

mod reference;

use fearless_simd::Simd;

use crate::Error;
use crate::encoding::{HashGrid, hash_grid};
use crate::field::{Decoder, Field, FieldKernels, Samples};
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

/// A multiresolution hash grid and its networks.
#[derive(Clone, Copy, Debug)]
pub struct HashGridField<'a> {
    /// Position encoding.
    pub grid: HashGrid<'a>,
    /// Networks.
    pub decoder: Decoder<'a>,
}

impl HashGridField<'_> {
    /// Values of an encoded point.
    #[must_use]
    pub const fn n_encoded(&self) -> usize {
        self.grid.config.n_output()
    }
}

impl Field for HashGridField<'_> {
    fn kind(&self) -> &'static str {
        "hash-grid"
    }

    fn channels(&self) -> usize {
        self.decoder.channels()
    }

    fn dtype(&self) -> DType {
        self.decoder.dtype()
    }

    fn limits(&self) -> Limits {
        self.decoder.limits(self.n_encoded())
    }

    /// A cell of the finest level.
    fn finest_detail(&self) -> f32 {
        let levels = 0..self.grid.config.n_levels as usize;
        1.0 / levels.map(|level| self.grid.config.level(level).scale).fold(1.0, f32::max)
    }

    fn validate(&self) -> Result<(), Error> {
        self.grid.validate()?;
        self.decoder.validate(self.n_encoded())
    }

    fn decoder(&self) -> Option<&Decoder<'_>> {
        Some(&self.decoder)
    }
}

impl FieldKernels for HashGridField<'_> {
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        hash_grid::encode(simd, &self.grid, points, work.a, work.stride);
    }

    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.decoder.density_features(simd, samples, work);
    }

    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        self.decoder.densities(simd, n, work);
    }
}
