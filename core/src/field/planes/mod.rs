//! The planes field: planes and lines, density network, colour network.

mod reference;

use fearless_simd::Simd;

use crate::Error;
use crate::encoding::{Planes, planes};
use crate::field::{Decoder, Field, FieldKernels, Samples};
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

/// Planes and lines (Chen et al. 2022, "TensoRF"), and networks.
///
/// In the paper densities are sums of products of their own, and colours come from a matrix and a
/// network; here both networks read all products, as they read a hash grid's values.
#[derive(Clone, Copy, Debug)]
pub struct PlanesField<'a> {
    /// Position encoding.
    pub planes: Planes<'a>,
    /// Networks.
    pub decoder: Decoder<'a>,
}

impl Field for PlanesField<'_> {
    fn kind(&self) -> &'static str {
        "planes"
    }

    fn channels(&self) -> usize {
        self.decoder.channels()
    }

    fn dtype(&self) -> DType {
        self.decoder.dtype()
    }

    fn limits(&self) -> Limits {
        self.decoder.limits(self.planes.n_output())
    }

    /// From an entry of a line to the next.
    fn finest_detail(&self) -> f32 {
        1.0 / (self.planes.resolution - 1) as f32
    }

    fn validate(&self) -> Result<(), Error> {
        self.planes.validate()?;
        self.decoder.validate(self.planes.n_output())
    }

    /// Four of a plane, two of a line.
    fn entries_read(&self, table: usize) -> usize {
        if table.is_multiple_of(2) { 4 } else { 2 }
    }

    fn decoder(&self) -> Option<&Decoder<'_>> {
        Some(&self.decoder)
    }
}

impl FieldKernels for PlanesField<'_> {
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        planes::encode(simd, &self.planes, points, work.a, work.stride);
    }

    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.decoder.density_features(simd, samples, work);
    }

    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        self.decoder.densities(simd, n, work);
    }
}
