//! The one door to the kinds of field.
//!
//! A new kind is a file beside this one, a variant of [`AnyField`] and a line in
//! [`each_kind`]; its Cargo feature is named in this file, in the module list and in
//! `Cargo.toml`.

use fearless_simd::Simd;

use crate::field::{Field, FieldKernels};

#[cfg(not(any(feature = "hash-grid", feature = "nerf")))]
compile_error!("pocketnerf-core needs at least one kind of field: feature `hash-grid` or `nerf`");

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
    HashGrid(super::HashGridField<'a>),
    /// The original NeRF networks.
    #[cfg(feature = "nerf")]
    Nerf(super::NerfField<'a>),
}

/// The one match over kinds: evaluates an expression with `$field` bound to the field.
macro_rules! each_kind {
    ($any:expr, $field:ident => $of:expr) => {
        match $any {
            #[cfg(feature = "hash-grid")]
            $crate::AnyField::HashGrid($field) => $of,
            #[cfg(feature = "nerf")]
            $crate::AnyField::Nerf($field) => $of,
        }
    };
}

pub(crate) use each_kind;

impl<'a> core::ops::Deref for AnyField<'a> {
    type Target = dyn Field + 'a;

    fn deref(&self) -> &Self::Target {
        each_kind!(self, field => field)
    }
}

impl<'a> AnyField<'a> {
    /// The field's kernels at a SIMD level.
    pub fn kernels<S: Simd>(&self) -> &(dyn FieldKernels<S> + 'a) {
        each_kind!(self, field => field)
    }
}
