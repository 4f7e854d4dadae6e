//! A network over the paper's positional encoding.

use crate::Error;
use crate::encoding::FrequencyConfig;
use crate::field::Decoder;

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
