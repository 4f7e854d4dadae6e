//! A network over the paper's positional encoding.

use fearless_simd::Simd;

use crate::Error;
use crate::encoding::{FrequencyConfig, frequency};
use crate::field::{Decoded, Decoder};

/// Positional encoding and networks.
#[derive(Clone, Copy, Debug)]
pub struct FrequencyField<'a> {
    /// Position encoding.
    pub encoding: FrequencyConfig,
    /// Networks.
    pub decoder: Decoder<'a>,
}

impl FrequencyField<'_> {
    /// Checks that encoding and networks fit together.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        self.encoding.validate()?;
        self.decoder.validate(self.encoding.n_output())
    }
}

impl Decoded for FrequencyField<'_> {
    fn decoder(&self) -> &Decoder<'_> {
        &self.decoder
    }

    fn n_encoded(&self) -> usize {
        self.encoding.n_output()
    }

    #[inline(always)]
    fn encode_rows<S: Simd>(&self, simd: S, points: [&[f32]; 3], out: &mut [f32], stride: usize) {
        frequency::encode(simd, self.encoding, points, out, stride);
    }
}
