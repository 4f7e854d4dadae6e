//! Radiance fields: density and features of points, and how features become
//! colour. One file a kind.

mod decoder;
#[cfg(feature = "hash-grid")]
mod hash_grid;
#[cfg(feature = "nerf")]
mod nerf;

pub use decoder::{Decoder, Shading};
#[cfg(feature = "hash-grid")]
pub use hash_grid::HashGridField;
#[cfg(feature = "nerf")]
pub use nerf::{Activation, NerfField, NerfNetwork};

use fearless_simd::Simd;

use crate::Error;
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

#[cfg(not(any(feature = "hash-grid", feature = "nerf")))]
compile_error!("pocketnerf-core needs at least one kind of field: feature `hash-grid` or `nerf`");

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

/// Density and what a ray accumulates, of points, in batches.
///
/// Methods are generic over the SIMD token and the stored type; a caller
/// dispatches once for many batches.
pub trait Field {
    /// The networks that make colours of what a ray has gathered; `None` where every
    /// sample has its own colour.
    fn deferred(&self) -> Option<&Decoder<'_>>;

    /// Values that a ray accumulates: K.
    fn channels(&self) -> usize;

    /// How the networks' parameters are stored.
    fn dtype(&self) -> DType;

    /// Scratch that the field needs.
    fn limits(&self) -> Limits;

    /// The first half of [`density_features`](Self::density_features): encodes
    /// positions to `work.a`.
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>);

    /// The second half: the networks, over what is in `work.a`.
    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>);

    /// Fills row 0 of `work.output` with sigma in 1 / scene unit; the others may hold
    /// anything then.
    #[inline(always)]
    fn densities<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.density_features(simd, samples, work);
    }

    /// Fills `work.output`: row 0 with sigma in 1 / scene unit, rows
    /// `1 ..= channels` with what a ray accumulates.
    #[inline(always)]
    fn density_features<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.encode(simd, samples.points, work);
        self.decode(simd, samples, work);
    }
}

/// A field that is a position encoding and the [`Decoder`] that such kinds share.
pub trait Decoded {
    /// What decodes positions.
    fn decoder(&self) -> &Decoder<'_>;

    /// Values that the position encoding gives for a point.
    fn n_encoded(&self) -> usize;

    /// Encodes positions to rows of `out`, `stride` values apart.
    fn encode_rows<S: Simd>(&self, simd: S, points: [&[f32]; 3], out: &mut [f32], stride: usize);
}

impl<D: Decoded> Field for D {
    #[inline(always)]
    fn deferred(&self) -> Option<&Decoder<'_>> {
        let decoder = self.decoder();
        (decoder.shading == Shading::PerRay).then_some(decoder)
    }

    #[inline(always)]
    fn channels(&self) -> usize {
        self.decoder().channels()
    }

    #[inline(always)]
    fn dtype(&self) -> DType {
        self.decoder().density.layers()[0].weight.dtype()
    }

    fn limits(&self) -> Limits {
        let decoder = self.decoder();
        Limits {
            width: self.n_encoded().max(decoder.density.max_width()).max(decoder.color.max_width()),
            rows: decoder.rows(self.n_encoded()),
            channels: decoder.channels().max(decoder.n_features as usize).max(3),
            ray_samples: 0,
        }
    }

    #[inline(always)]
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        self.encode_rows(simd, points, work.a, work.stride);
    }

    #[inline(always)]
    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.decoder().density_features(simd, samples, work);
    }

    /// Without the colour network.
    #[inline(always)]
    fn densities<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.encode(simd, samples.points, work);
        self.decoder().densities(simd, samples.len(), work);
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
    /// The paper's networks.
    #[cfg(feature = "nerf")]
    Nerf(NerfField<'a>),
}

impl AnyField<'_> {
    /// The kind's name, as `info` prints it.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(_) => "hash-grid",
            #[cfg(feature = "nerf")]
            Self::Nerf(_) => "nerf",
        }
    }

    /// Scratch that the field needs.
    #[must_use]
    pub fn limits(&self) -> Limits {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => field.limits(),
            #[cfg(feature = "nerf")]
            Self::Nerf(field) => field.limits(),
        }
    }

    /// The networks, where the kind has a [`Decoder`].
    #[must_use]
    pub fn decoder(&self) -> Option<&Decoder<'_>> {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => Some(&field.decoder),
            #[cfg(feature = "nerf")]
            Self::Nerf(_) => None,
        }
    }

    /// Values that a ray accumulates: K.
    #[must_use]
    pub fn channels(&self) -> usize {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => field.channels(),
            #[cfg(feature = "nerf")]
            Self::Nerf(field) => field.channels(),
        }
    }

    /// How the networks' parameters are stored.
    #[must_use]
    pub fn dtype(&self) -> DType {
        match self {
            #[cfg(feature = "hash-grid")]
            Self::HashGrid(field) => field.dtype(),
            #[cfg(feature = "nerf")]
            Self::Nerf(field) => field.dtype(),
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
            #[cfg(feature = "nerf")]
            Self::Nerf(field) => field.validate(),
        }
    }
}
