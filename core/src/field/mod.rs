//! Radiance fields: density and features of points, and how features become
//! colour.
//!
//! One file or folder a kind. This file is the one door to them: a new kind is a module, a
//! variant of [`AnyField`] and a line of `each_kind`, each with its Cargo feature.

mod decoder;
#[cfg(feature = "derf")]
mod derf;
#[cfg(feature = "hash-grid")]
mod hash_grid;
#[cfg(feature = "nerf")]
mod nerf;
#[cfg(feature = "planes")]
mod planes;
#[cfg(feature = "plenoxels")]
mod plenoxels;

pub use decoder::{Decoder, Shading};
#[cfg(feature = "derf")]
pub use derf::{DerfField, HeadShape, MAX_HEADS};
#[cfg(feature = "hash-grid")]
pub use hash_grid::HashGridField;
#[cfg(feature = "nerf")]
pub use nerf::{Activation, NerfField, NerfNetwork};
#[cfg(feature = "planes")]
pub use planes::PlanesField;
#[cfg(feature = "plenoxels")]
pub use plenoxels::PlenoxelField;

use fearless_simd::{Level, Simd, dispatch};

use crate::Error;
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;

#[cfg(not(any(
    feature = "hash-grid",
    feature = "nerf",
    feature = "plenoxels",
    feature = "planes",
    feature = "derf"
)))]
compile_error!(
    "pocketnerf-core needs at least one kind of field: feature `hash-grid`, `nerf`, `plenoxels`, `planes` or `derf`"
);

/// Most features that a ray may accumulate.
pub const MAX_CHANNELS: usize = 32;

/// e^15, 1 / unit length: densities are cut off here.
pub const MAX_SIGMA: f32 = 3_269_017.4;

/// A batch of points at which a field is evaluated. All slices have the same length, a
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

/// What every kind of field says of itself. A field turns points and directions into
/// densities and channels; it knows no ray.
pub trait Field {
    /// The kind's name, as `info` prints it.
    fn kind(&self) -> &'static str;

    /// Values that a ray accumulates: K.
    fn channels(&self) -> usize;

    /// How the networks' parameters are stored.
    fn dtype(&self) -> DType;

    /// Scratch that the field needs.
    fn limits(&self) -> Limits;

    /// How far apart, in unit coordinates, two things are that the field can just tell
    /// apart.
    fn finest_detail(&self) -> f32;

    /// Checks that the parts of the field fit together.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    fn validate(&self) -> Result<(), Error>;

    /// Entries of a table, in the order of the file, between which a point lies.
    fn entries_read(&self, _table: usize) -> usize {
        8
    }

    /// The networks behind an encoding, where the kind has them.
    fn decoder(&self) -> Option<&Decoder<'_>> {
        None
    }

    /// The networks that make colours of what a ray has accumulated; `None` where every
    /// sample has its own colour.
    fn deferred(&self) -> Option<&Decoder<'_>> {
        self.decoder().filter(|decoder| decoder.shading == Shading::PerRay)
    }

    /// The field that says where hierarchical sampling places its samples; `None`: the
    /// same.
    fn coarse(&self) -> Option<AnyField<'_>> {
        None
    }
}

/// A field's kernels. Only [`march::evaluate`](crate::march::evaluate) runs them, through
/// [`AnyField`].
pub trait FieldKernels: Field {
    /// Encodes unit points, a multiple of 16 of them, to `work.a`.
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>);

    /// The networks over what [`encode`](Self::encode) has left in `work.a`: fills row 0
    /// of `work.output` with sigma in 1 / scene unit and rows `1 ..= channels` with what a
    /// ray accumulates.
    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>);

    /// The same for sigma alone, of `n` points; the other rows may hold anything then.
    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>);
}

/// Features of a point or of a ray as the oracle has them; those that the field does not have
/// are 0.
pub(crate) type Features = [f64; MAX_CHANNELS];

/// A kind of field as the [oracle](crate::reference) has it: one point at a time, in f64,
/// without the kernels.
pub(crate) trait ReferenceField {
    /// Sigma, per scene unit, at unit point `u`, and what a ray along `direction`
    /// accumulates: a colour or features.
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features);
}

/// A field of any kind that this build links. What all kinds have in common is that it is
/// a [`Field`].
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
    /// The original NeRF networks.
    #[cfg(feature = "nerf")]
    Nerf(NerfField<'a>),
    /// A sparse grid of densities and spherical harmonics.
    #[cfg(feature = "plenoxels")]
    Plenoxels(PlenoxelField<'a>),
    /// Planes and lines, and small networks.
    #[cfg(feature = "planes")]
    Planes(PlanesField<'a>),
    /// Small networks for parts of a scene.
    #[cfg(feature = "derf")]
    Derf(DerfField<'a>),
}

/// The one match over kinds: evaluates an expression with `$field` bound to the field.
macro_rules! each_kind {
    ($any:expr, $field:ident => $of:expr) => {
        match $any {
            #[cfg(feature = "hash-grid")]
            $crate::AnyField::HashGrid($field) => $of,
            #[cfg(feature = "nerf")]
            $crate::AnyField::Nerf($field) => $of,
            #[cfg(feature = "plenoxels")]
            $crate::AnyField::Plenoxels($field) => $of,
            #[cfg(feature = "planes")]
            $crate::AnyField::Planes($field) => $of,
            #[cfg(feature = "derf")]
            $crate::AnyField::Derf($field) => $of,
        }
    };
}

impl ReferenceField for AnyField<'_> {
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        each_kind!(self, field => field.reference(u, direction))
    }
}

impl<'a> core::ops::Deref for AnyField<'a> {
    type Target = dyn Field + 'a;

    fn deref(&self) -> &Self::Target {
        each_kind!(self, field => field)
    }
}

/// [`FieldKernels`] of any kind, at a SIMD level. Kernels are compiled here, once, however
/// many crates march through a field.
impl AnyField<'_> {
    pub(crate) fn encode(&self, level: Level, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        dispatch!(level, simd => each_kind!(self, field => field.encode(simd, points, work)));
    }

    pub(crate) fn decode(&self, level: Level, samples: Samples<'_>, work: &mut Workspace<'_>) {
        dispatch!(level, simd => each_kind!(self, field => field.decode(simd, samples, work)));
    }

    pub(crate) fn decode_density(&self, level: Level, n: usize, work: &mut Workspace<'_>) {
        dispatch!(level, simd => each_kind!(self, field => field.decode_density(simd, n, work)));
    }
}
