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

use fearless_simd::Simd;

use crate::Error;
use crate::scratch::{Limits, Workspace};
use crate::store::Store;
use crate::tensor::DType;

#[cfg(not(any(feature = "hash-grid", feature = "frequency")))]
compile_error!(
    "pocketnerf-core needs at least one kind of field: feature `hash-grid` or `frequency`"
);

/// Most features that a ray may accumulate.
pub const MAX_CHANNELS: usize = 32;

/// A batch of points to ask a field about. All slices have the same length, a
/// multiple of 16.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'s> {
    /// x, y and z in unit coordinates.
    pub points: [&'s [f32]; 3],
    /// Unit directions towards the points; read by per-sample shading alone.
    pub directions: [&'s [f32]; 3],
}

impl Samples<'_> {
    /// Number of points.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.points[0].len()
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.points[0].is_empty()
    }
}

/// Density and features of points, in batches.
///
/// Methods are generic over the SIMD token and the stored type; a caller
/// dispatches once for many batches.
pub trait Field {
    /// What encodes positions differs; what decodes them is shared.
    fn decoder(&self) -> &Decoder<'_>;

    /// Values that the position encoding gives for a point.
    fn n_encoded(&self) -> usize;

    /// Encodes positions to rows of `out`, `stride` values apart.
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], out: &mut [f32], stride: usize);

    /// Fills `work.output`: row 0 with sigma in 1 / scene unit, rows
    /// `1 ..= channels` with what a ray accumulates.
    #[inline(always)]
    fn density_features<S: Simd, T: Store>(
        &self,
        simd: S,
        samples: Samples<'_>,
        work: &mut Workspace<'_>,
    ) {
        self.encode::<S>(simd, samples.points, work.a, work.stride);
        self.decoder().density_features::<S, T>(simd, samples, work);
    }

    /// Scratch that the field needs.
    fn limits(&self) -> Limits {
        let decoder = self.decoder();
        Limits {
            width: self.n_encoded().max(decoder.density.max_width()).max(decoder.color.max_width()),
            rows: decoder.rows(self.n_encoded()),
            channels: decoder.channels().max(decoder.n_features as usize).max(3),
        }
    }
}

/// A field of any kind that this build links: the type at the file boundary.
#[non_exhaustive]
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "without a heap there is no box; how sizes differ depends on the kinds linked"
)]
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

    /// Scratch that the field needs.
    #[must_use]
    pub fn limits(&self) -> Limits {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => field.limits(),
            #[cfg(feature = "frequency")]
            Self::Frequency(field) => field.limits(),
        }
    }

    /// The networks.
    #[must_use]
    pub fn decoder(&self) -> &Decoder<'_> {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => &field.decoder,
            #[cfg(feature = "frequency")]
            Self::Frequency(field) => &field.decoder,
        }
    }

    /// How the networks' parameters are stored.
    #[must_use]
    pub fn dtype(&self) -> DType {
        self.decoder().density.layers()[0].weight.dtype()
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
