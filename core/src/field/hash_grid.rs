//! The hash-grid field: grid, density network, colour network.

use crate::Error;
use crate::encoding::HashGrid;
use crate::field::Decoder;

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
        self.decoder.validate(self.grid.config.n_output())?;
        if self.grid.levels[0].dtype() != self.decoder.density.layers()[0].weight.dtype() {
            return Err(Error::Shape("grid and networks of different types"));
        }
        Ok(())
    }
}
