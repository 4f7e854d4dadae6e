//! Radiance fields: density and features of points, and how features become
//! colour. One file a kind.

mod decoder;
#[cfg(feature = "frequency")]
mod frequency;
#[cfg(feature = "hash-grid")]
mod hash_grid;

pub use decoder::{Decoder, Shading};
#[cfg(feature = "frequency")]
pub use frequency::FrequencyField;
#[cfg(feature = "hash-grid")]
pub use hash_grid::HashGridField;

use crate::Error;

/// Most features that a ray may accumulate.
pub const MAX_CHANNELS: usize = 32;

/// A field of any kind that this build links: the type at the file boundary.
#[non_exhaustive]
#[derive(Clone, Copy, Debug)]
pub enum AnyField<'a> {
    /// Multiresolution hash grid and small networks.
    #[cfg(feature = "hash-grid")]
    HashGrid(HashGridField<'a>),
    /// Positional encoding and a network.
    #[cfg(feature = "frequency")]
    Frequency(FrequencyField<'a>),
}

impl AnyField<'_> {
    /// The kind's name, as `info` prints it.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(_) => "hash-grid",
            #[cfg(feature = "frequency")]
            Self::Frequency(_) => "frequency",
        }
    }

    /// Checks that the parts of the field fit together.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => field.validate(),
            #[cfg(feature = "frequency")]
            Self::Frequency(field) => field.validate(),
        }
    }
}
