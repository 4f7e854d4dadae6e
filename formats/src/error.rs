//! Errors of files that cannot be read.

use core::fmt;

use crate::container::{MAGIC, MAJOR, MAX_SECTIONS, MINOR, SectionId};
use crate::tensor_name::TensorName;

/// Why a file was refused: what was found and what was expected.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormatError {
    /// The first bytes are not those of a `.pnerf` file.
    NotPnerf {
        /// The first eight bytes; zeros where the file is shorter.
        found: [u8; 8],
    },
    /// The first bytes are a `.pnerf` file's after a transfer in text mode.
    TextTransfer {
        /// The first eight bytes.
        found: [u8; 8],
    },
    /// The file's major version is not the one that this build reads.
    Version {
        /// Major and minor version in the file.
        found: [u16; 2],
    },
    /// The file's length differs from the one in its header.
    Length {
        /// Bytes that the header states or needs.
        expected: u64,
        /// Bytes that were given.
        found: u64,
    },
    /// More sections than a file may have.
    TooManySections {
        /// Sections that the header states.
        found: u32,
    },
    /// Header or section table is damaged.
    HeaderChecksum {
        /// CRC-32 in the header.
        expected: u32,
        /// CRC-32 of the bytes.
        found: u32,
    },
    /// The section does not come after the one before it in the table.
    Order(SectionId),
    /// The section does not begin where the one before it ends.
    Offset {
        /// The section.
        section: SectionId,
        /// Where it should begin.
        expected: u64,
        /// Where it begins according to the table.
        found: u64,
    },
    /// The section reaches beyond the end of the file.
    Bounds {
        /// The section.
        section: SectionId,
        /// Its length in the table.
        found: u64,
        /// Bytes from its offset to the end of the file.
        available: u64,
    },
    /// A raw section's decoded length differs from its stored length.
    DecodedLength {
        /// The section.
        section: SectionId,
        /// Stored length.
        expected: u64,
        /// Decoded length.
        found: u64,
    },
    /// A critical section of a kind that this build does not know.
    UnknownSection(SectionId),
    /// A critical section in a version that this build does not know.
    UnknownVersion {
        /// The section.
        section: SectionId,
        /// Its version.
        found: u16,
    },
    /// A critical section in an encoding that this build does not know.
    UnknownEncoding {
        /// The section.
        section: SectionId,
        /// Its encoding.
        found: u16,
    },
    /// A section that the model needs is not there.
    Missing(SectionId),
    /// The section's bytes are damaged.
    Checksum {
        /// The section.
        section: SectionId,
        /// CRC-32 in the table.
        expected: u32,
        /// CRC-32 of the bytes.
        found: u32,
    },
    /// The bytes between the section and the part before it are not zero.
    Padding(SectionId),
    /// The section's packed payload cannot be decoded.
    Packed(SectionId),
    /// The caller's memory does not hold the unpacked file.
    Room {
        /// Bytes needed.
        needed: u64,
        /// Bytes given.
        given: u64,
    },
    /// A metadata section is longer than any such section may be.
    MetadataLength {
        /// The section.
        section: SectionId,
        /// Most bytes allowed.
        limit: u64,
        /// Its length.
        found: u64,
    },
    /// A metadata section ends before its fields do, holds bytes after them,
    /// or holds a field that cannot be read.
    Metadata(SectionId),
    /// A coded field holds a code that this build does not know.
    UnknownCode {
        /// The section.
        section: SectionId,
        /// The field.
        field: &'static str,
        /// The code.
        found: u32,
    },
    /// The field is of this kind, which this build leaves out: the kind's name
    /// is that of the feature that links it.
    FieldKind(&'static str),
    /// The field lives in a space of this kind, which this build leaves out; named as
    /// the feature that links it.
    SpaceKind(&'static str),
    /// A metadata field is not finite or outside its range.
    Value {
        /// The section.
        section: SectionId,
        /// The field.
        field: &'static str,
    },
    /// The tensor directory lists a tensor twice, or one that the field has not.
    UnexpectedTensor(TensorName),
    /// The tensor directory lacks a tensor that the field needs.
    MissingTensor(TensorName),
    /// A tensor's shape differs from the one that FIELD implies.
    TensorShape {
        /// The tensor.
        tensor: TensorName,
        /// Rows and columns that FIELD implies.
        expected: [u32; 2],
        /// Rows and columns in the directory.
        found: [u32; 2],
    },
    /// A tensor's section does not match its shape and type.
    Tensor(TensorName, pocketnerf_core::Error),
    /// A weight is infinite or not a number.
    NotFinite(TensorName),
    /// The parts do not make a model that can be rendered.
    Model(pocketnerf_core::Error),
}

impl From<pocketnerf_core::Error> for FormatError {
    fn from(error: pocketnerf_core::Error) -> Self {
        Self::Model(error)
    }
}

impl core::error::Error for FormatError {}

/// Bytes as two-digit hexadecimal numbers.
struct Hex([u8; 8]);

impl fmt::Display for Hex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, byte) in self.0.iter().enumerate() {
            write!(f, "{}{byte:02x}", if i == 0 { "" } else { " " })?;
        }
        Ok(())
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotPnerf { found } => {
                write!(f, "not a .pnerf file: begins with {}, expected {}", Hex(found), Hex(MAGIC))
            }
            Self::TextTransfer { found } => write!(
                f,
                "damaged by a transfer in text mode: begins with {}, expected {}",
                Hex(found),
                Hex(MAGIC)
            ),
            Self::Version { found: [major, minor] } => write!(
                f,
                "written by format version {major}.{minor}; \
                 this build reads version {MAJOR}.x (knows {MAJOR}.{MINOR})"
            ),
            Self::Length { expected, found } if found < expected => {
                write!(f, "the file is cut short: {found} bytes where {expected} were expected")
            }
            Self::Length { expected, found } => {
                write!(f, "bytes after the end of the file: {found} where {expected} were expected")
            }
            Self::TooManySections { found } => {
                write!(f, "{found} sections where at most {MAX_SECTIONS} were expected")
            }
            Self::HeaderChecksum { expected, found } => write!(
                f,
                "header: checksum {found:#010x} where {expected:#010x} was expected: \
                 the file is damaged"
            ),
            Self::Order(section) => {
                write!(f, "{section}: stands in the table after a section it should precede")
            }
            Self::Offset { section, expected, found } => {
                write!(f, "{section}: begins at byte {found} where {expected} was expected")
            }
            Self::Bounds { section, found, available } => {
                write!(f, "{section}: {found} bytes long where the file has {available} left")
            }
            Self::DecodedLength { section, expected, found } => {
                write!(f, "{section}: decoded length {found} where {expected} was expected")
            }
            Self::UnknownSection(section) => write!(
                f,
                "{section}: this build does not know it, and the file says that it is needed"
            ),
            Self::UnknownVersion { section, found } => {
                write!(f, "{section}: version {found} where version 1 was expected")
            }
            Self::UnknownEncoding { section, found } => {
                write!(
                    f,
                    "{section}: encoding {found} where 0 (raw) was expected; a packed file has to \
                     be unpacked first"
                )
            }
            Self::Missing(section) => write!(f, "{section}: not in the file"),
            Self::Checksum { section, expected, found } => write!(
                f,
                "{section}: checksum {found:#010x} where {expected:#010x} was expected: \
                 the file is damaged"
            ),
            Self::Padding(section) => {
                write!(f, "{section}: the bytes before it are not zero: the file is damaged")
            }
            Self::Packed(section) => {
                write!(f, "{section}: its packed bytes cannot be decoded: the file is damaged")
            }
            Self::Room { needed, given } => {
                write!(f, "the unpacked file has {needed} bytes where there is room for {given}")
            }
            Self::MetadataLength { section, limit, found } => {
                write!(f, "{section}: {found} bytes where at most {limit} were expected")
            }
            Self::Metadata(section) => write!(f, "{section}: its fields cannot be read"),
            Self::UnknownCode { section, field, found } => {
                write!(f, "{section}: code {found} for {field} is unknown to this build")
            }
            Self::FieldKind(kind) => write!(
                f,
                "a {kind} field, which this build leaves out: it needs the cargo feature `{kind}`"
            ),
            Self::SpaceKind(kind) => write!(
                f,
                "a field in {kind} space, which this build leaves out: it needs the cargo feature \
                 `{kind}`"
            ),
            Self::Value { section, field } => {
                write!(f, "{section}: {field} is not finite or outside its range")
            }
            Self::UnexpectedTensor(tensor) => {
                write!(f, "tensor {tensor}: listed twice, or not part of the field")
            }
            Self::MissingTensor(tensor) => write!(f, "tensor {tensor}: not in the file"),
            Self::TensorShape { tensor, expected, found } => write!(
                f,
                "tensor {tensor}: shape {}x{} where {}x{} was expected",
                found[0], found[1], expected[0], expected[1]
            ),
            Self::Tensor(tensor, error) => write!(f, "tensor {tensor}: {error}"),
            Self::NotFinite(tensor) => {
                write!(f, "tensor {tensor}: holds a value that is infinite or not a number")
            }
            Self::Model(error) => write!(f, "{error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::*;
    use crate::container::kind;

    #[test]
    fn messages_say_what_was_found_and_expected() {
        let png = FormatError::NotPnerf { found: *b"\x89PNG\r\n\x1a\n" };
        assert_eq!(
            png.to_string(),
            "not a .pnerf file: begins with 89 50 4e 47 0d 0a 1a 0a, \
             expected ab 50 4e 52 46 0d 0a 1a"
        );
        assert_eq!(
            FormatError::Version { found: [2, 0] }.to_string(),
            "written by format version 2.0; this build reads version 1.x (knows 1.0)"
        );
        let section = SectionId { kind: kind::GRID, index: 3 };
        assert_eq!(
            FormatError::Checksum { section, expected: 1, found: 0xabc }.to_string(),
            "section GRID level 3: checksum 0x00000abc where 0x00000001 was expected: \
             the file is damaged"
        );
        let section = SectionId { kind: 0x2a, index: 0 };
        assert_eq!(
            FormatError::UnknownSection(section).to_string(),
            "section of kind 0x2a: this build does not know it, \
             and the file says that it is needed"
        );
    }
}
