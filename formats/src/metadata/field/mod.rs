//! FIELD and the tensors: the table of the kinds of field.
//!
//! A kind is one file beside this one, which implements [`FieldKind`], and one line of the
//! table. A file of a kind that this build leaves out is refused here, by the name of its
//! feature.

#[cfg(feature = "corner-index")]
mod corner_levels;
#[allow(dead_code, reason = "what kinds of field share; a build may link none of these kinds")]
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
mod widths;

use pocketnerf_core::{AnyField, TensorView, field};

use super::Fields;
use crate::FormatError;
use crate::directory::Listed;
use crate::tensor_name::{Known, TensorName};

/// How a kind of field lies in a file.
pub(crate) trait FieldKind<'a>: Sized {
    /// The names of its tensors.
    const NAMES: &'static [Known];
    /// The most tensors that it may have.
    const MAX_TENSORS: usize;

    /// What FIELD says after the code.
    type Metadata;

    /// Reads FIELD after the code.
    fn read(fields: Fields<'a>) -> Result<Self::Metadata, FormatError>;

    /// Takes the tensors of the field that `metadata` describes.
    fn open(metadata: &Self::Metadata, listed: &mut Listed<'a>) -> Result<Self, FormatError>;

    /// What FIELD says of the field; `None` for a choice that the format has no code for.
    fn metadata(&self) -> Option<Self::Metadata>;

    /// Appends FIELD after the code.
    fn write<W: Extend<u8>>(metadata: &Self::Metadata, bytes: W) -> Option<W>;

    /// The weights with their names, in the order of the file.
    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)>;
}

/// Makes of the table all that depends on which kinds there are.
macro_rules! kinds {
    ($($code:literal $feature:tt $variant:ident($field:ident);)*) => {
        /// Codes and features of all kinds, linked or not.
        const KINDS: &[(u8, &str)] = &[$(($code, $feature)),*];

        /// The names of the tensors of the kinds that are linked.
        const NAMES: &[&[Known]] =
            &[$(#[cfg(feature = $feature)] <field::$field<'_> as FieldKind<'_>>::NAMES),*];

        /// The most tensors that a field may have.
        pub(crate) const MAX_TENSORS: usize = largest(
            &[$(#[cfg(feature = $feature)] <field::$field<'_> as FieldKind<'_>>::MAX_TENSORS),*]
        );

        /// The field that FIELD describes; `None` for a kind that is not linked.
        fn linked<'a>(
            code: u8,
            fields: Fields<'a>,
            list: impl FnOnce() -> Result<Listed<'a>, FormatError>,
        ) -> Option<Result<AnyField<'a>, FormatError>> {
            match code {
                $(#[cfg(feature = $feature)]
                $code => Some(open(fields, list).map(AnyField::$variant)),)*
                _ => None,
            }
        }

        /// Appends FIELD; `None` for a choice that the format has no code for.
        pub(crate) fn write<W: Extend<u8>>(field: &AnyField<'_>, bytes: W) -> Option<W> {
            match field {
                $(#[cfg(feature = $feature)]
                AnyField::$variant(field) => append(field, $code, bytes),)*
                _ => None,
            }
        }

        /// The weights of a field with their names, in the order of the file.
        pub fn tensors<'f, 'a>(
            field: &'f AnyField<'a>,
        ) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
            let tensors = core::iter::empty();
            $(#[cfg(feature = $feature)]
            let tensors = tensors.chain(
                match field {
                    AnyField::$variant(field) => Some(field),
                    _ => None,
                }
                .into_iter()
                .flat_map(FieldKind::tensors),
            );)*
            tensors
        }
    };
}

// Code in FIELD, cargo feature, variant of `AnyField`. Code 1 is reserved.
kinds! {
    0 "hash-grid" HashGrid(HashGridField);
    2 "nerf" Nerf(NerfField);
    3 "plenoxels" Plenoxels(PlenoxelField);
    4 "planes" Planes(PlanesField);
    5 "derf" Derf(DerfField);
}

/// The field that FIELD describes, of the listed tensors and no others.
// Not inlined: on a bare target that is a kilobyte less.
#[inline(never)]
pub(crate) fn read<'a>(
    mut fields: Fields<'a>,
    list: impl FnOnce() -> Result<Listed<'a>, FormatError>,
) -> Result<AnyField<'a>, FormatError> {
    let code = fields.take()?;
    let unknown = fields.unknown("kind of field", code);
    linked(code, fields, list).unwrap_or_else(|| {
        let kind = KINDS.iter().find(|kind| kind.0 == code);
        Err(kind.map_or(unknown, |(_, feature)| FormatError::FieldKind(feature)))
    })
}

fn append<'a, F: FieldKind<'a>, W: Extend<u8>>(field: &F, code: u8, bytes: W) -> Option<W> {
    F::write(&field.metadata()?, super::append(bytes, &code)?)
}

fn open<'a, F: FieldKind<'a>>(
    fields: Fields<'a>,
    list: impl FnOnce() -> Result<Listed<'a>, FormatError>,
) -> Result<F, FormatError> {
    let metadata = F::read(fields)?;
    let mut listed = list()?;
    let field = F::open(&metadata, &mut listed)?;
    listed.finish()?;
    Ok(field)
}

/// What is known of a tensor's name.
pub(crate) fn known(name: TensorName) -> Option<&'static Known> {
    NAMES.iter().copied().flatten().find(|known| known.code == name.code)
}

const fn largest(values: &[usize]) -> usize {
    let (mut most, mut i) = (0, 0);
    while i < values.len() {
        if values[i] > most {
            most = values[i];
        }
        i += 1;
    }
    most
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::test_section;

    const TENSORS: FormatError = FormatError::Missing(SectionId::first(kind::TENSORS));

    /// What is wrong with FIELD, in a file without tensors.
    fn error(bytes: &[u8]) -> FormatError {
        let fields = Fields::open(&test_section(kind::FIELD, bytes)).unwrap();
        read(fields, || Err(TENSORS)).unwrap_err()
    }

    const HASH_GRID: [u8; 25] = [
        0, 8, 4, 17, 0xac, 0x02, 0, 0, 0xc0, 0x3f, 0, 15, 4, 1, 0, 0, 0, 0xc0, 3, 32, 64, 16, 2,
        31, 3,
    ];
    /// One octave, no directions, one layer of eight.
    #[rustfmt::skip]
    const NERF: [u8; 45] = [
        2,
        0, 1, 0, 0,  0,
        0, 0, 0x80, 0x3f,  0, 0, 0x80, 0x3f,  0, 0, 0x80, 0x3f,
        0, 0, 0, 0,        0, 0, 0, 0,        0, 0, 0, 0,
        0,  0, 0, 0x80, 0x3f,
        2, 6, 8,  0, 0,  0,  2, 8, 3,
        0,
    ];

    /// Eight voxels along an axis, four harmonics a colour.
    const PLENOXELS: [u8; 7] = [3, 8, 2, 0, 0, 0, 0];
    /// No octaves, no directions, one layer of eight.
    const DERF: [u8; 12] = [5, 0, 0, 1, 8, 0, 8, 0, 0, 0, 0x80, 0x3f];
    /// Eight entries along an axis, 16 components.
    const PLANES: [u8; 17] = [4, 8, 16, 15, 4, 1, 0, 0, 0, 0xc0, 3, 48, 64, 16, 2, 31, 3];

    #[test]
    fn a_kind_that_is_left_out_is_refused_by_name() {
        let all = [&HASH_GRID[..], &NERF, &PLENOXELS, &PLANES, &DERF];
        assert_eq!(all.len(), KINDS.len());
        for (bytes, (code, kind)) in all.into_iter().zip(KINDS) {
            assert_eq!(bytes[0], *code);
            // What is linked is read up to its tensors.
            let linked = match *kind {
                "hash-grid" => cfg!(feature = "hash-grid"),
                "nerf" => cfg!(feature = "nerf"),
                "plenoxels" => cfg!(feature = "plenoxels"),
                "planes" => cfg!(feature = "planes"),
                _ => cfg!(feature = "derf"),
            };
            let expected = if linked { TENSORS } else { FormatError::FieldKind(kind) };
            assert_eq!(error(bytes), expected);
        }
    }

    #[test]
    fn codes_without_a_kind() {
        let section = SectionId::first(kind::FIELD);
        // 1 is reserved.
        for found in [1, 6, 0x7f] {
            let unknown =
                FormatError::UnknownCode { section, field: "kind of field", found: found.into() };
            assert_eq!(error(&[found, 10, 1]), unknown);
        }
    }

    #[test]
    fn names_have_codes_of_their_own() {
        let all = || NAMES.iter().copied().flatten();
        for name in all() {
            // Kinds that have the same networks have the same names.
            for other in all() {
                assert_eq!(other.code == name.code, other.text == name.text, "{}", name.text);
            }
            assert!(TensorName::known(name.code, 0).is_some());
            assert_eq!(TensorName::known(name.code, 9).is_some(), name.several);
        }
        assert_eq!(TensorName::known(0xff, 0), None);
        for (names, i) in NAMES.iter().flat_map(|names| (0..names.len()).map(move |i| (names, i))) {
            assert!(
                names[..i].iter().all(|before| before.code != names[i].code),
                "{}",
                names[i].text
            );
        }
    }

    #[test]
    fn names_say_which_layer() {
        let texts =
            [(0, "grid level 3"), (15, "coarse trunk weight 3"), (10, "fine density bias 3")];
        for (code, text) in texts {
            let name = TensorName::new(code, 3);
            assert_eq!(name.to_string() == text, known(name).is_some());
        }
    }
}
