//! The paper's positional encoding (Mildenhall et al. 2020, equation 4).

use crate::Error;

/// Sines and cosines of octaves of a position.
///
/// A point x (unit coordinates, centred: `2 u - 1`) becomes, for
/// k = 0 .. `n_frequencies`, `sin(2^k π x)` over x, y, z, then `cos(2^k π x)`
/// over x, y, z; before these the three coordinates themselves when
/// `include_input`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrequencyConfig {
    /// Octaves, 1 to 16.
    pub n_frequencies: u32,
    /// Whether x itself stands before the sines.
    pub include_input: bool,
}

impl FrequencyConfig {
    /// Values that the encoding gives for a point.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        (6 * self.n_frequencies + if self.include_input { 3 } else { 0 }) as usize
    }

    /// Checks the number of octaves.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub const fn validate(&self) -> Result<(), Error> {
        if self.n_frequencies == 0 || self.n_frequencies > 16 {
            return Err(Error::Range("frequency encoding n_frequencies"));
        }
        Ok(())
    }
}
