//! The hash-grid field: grid, density network, colour network.

use fearless_simd::Simd;

use crate::Error;
use crate::encoding::{HashGrid, hash_grid};
use crate::field::{Decoded, Decoder};

/// A multiresolution hash grid and its networks.
#[derive(Clone, Copy, Debug)]
pub struct HashGridField<'a> {
    /// Position encoding.
    pub grid: HashGrid<'a>,
    /// Networks.
    pub decoder: Decoder<'a>,
}

impl HashGridField<'_> {
    /// Checks that grid and networks fit together.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        self.grid.validate()?;
        self.decoder.validate(self.grid.config.n_output())
    }
}

impl Decoded for HashGridField<'_> {
    fn decoder(&self) -> &Decoder<'_> {
        &self.decoder
    }

    fn n_encoded(&self) -> usize {
        self.grid.config.n_output()
    }

    #[inline(always)]
    fn encode_rows<S: Simd>(&self, simd: S, points: [&[f32]; 3], out: &mut [f32], stride: usize) {
        hash_grid::encode(simd, &self.grid, points, out, stride);
    }
}
