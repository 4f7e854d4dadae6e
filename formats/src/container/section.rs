//! Sections, the parts of a file.

use core::fmt;

use super::checksum;
use super::header::{u16_at, u32_at, u64_at};
use crate::FormatError;

/// Numbers of the section kinds.
///
/// Those below [`PROGRAM`](kind::PROGRAM) belong to the format; a program numbers its own
/// sections, such as a checkpoint's, from there.
pub mod kind {
    /// Metadata: the map from model to dataset coordinates, and a name.
    pub const SCENE: u32 = 1;
    /// Metadata: the space of the field.
    pub const SPACE: u32 = 2;
    /// Metadata: steps along a ray.
    pub const SAMPLING: u32 = 3;
    /// Metadata: kind and configuration of the field.
    pub const FIELD: u32 = 4;
    /// Metadata: background, colour space, default camera.
    pub const DISPLAY: u32 = 5;
    /// Metadata: how the model was made.
    pub const PROVENANCE: u32 = 6;
    /// Metadata: size of the occupancy grid.
    pub const OCCUPANCY: u32 = 7;
    /// Metadata: the tensor directory.
    pub const TENSORS: u32 = 8;
    /// Metadata: the tolerance for interpolated pixels.
    pub const DETAIL: u32 = 9;
    /// Metadata: hierarchical sampling.
    pub const HIERARCHICAL: u32 = 10;
    /// Metadata: the point of a pixel through which training rays passed.
    pub const PIXELS: u32 = 11;
    /// Metadata: the default quality of renderings.
    pub const QUALITY: u32 = 12;
    /// Metadata: where the photographs were taken.
    pub const PHOTOGRAPHS: u32 = 13;
    /// Metadata: what is up in the dataset, and how long its unit is.
    pub const WORLD: u32 = 14;
    /// Raw: the table of one hash grid level; the index is the level.
    pub const GRID: u32 = 16;
    /// Raw: one weight or bias; numbered in the order of the directory.
    pub const NETWORK: u32 = 17;
    /// Raw: block numbers of the occupancy grid.
    pub const OCC_COARSE: u32 = 18;
    /// Raw: bits of the occupied blocks.
    pub const OCC_FINE: u32 = 19;
    /// The first number that is a program's own.
    pub const PROGRAM: u32 = 0x1000;

    /// The name of a kind that this build knows.
    #[must_use]
    pub const fn name(kind: u32) -> Option<&'static str> {
        Some(match kind {
            SCENE => "SCENE",
            SPACE => "SPACE",
            SAMPLING => "SAMPLING",
            FIELD => "FIELD",
            DISPLAY => "DISPLAY",
            PROVENANCE => "PROVENANCE",
            OCCUPANCY => "OCCUPANCY",
            TENSORS => "TENSORS",
            DETAIL => "DETAIL",
            HIERARCHICAL => "HIERARCHICAL",
            PIXELS => "PIXELS",
            QUALITY => "QUALITY",
            PHOTOGRAPHS => "PHOTOGRAPHS",
            WORLD => "WORLD",
            GRID => "GRID",
            NETWORK => "NETWORK",
            OCC_COARSE => "OCC_COARSE",
            OCC_FINE => "OCC_FINE",
            _ => return None,
        })
    }
}

/// Most sections a file may have.
pub const MAX_SECTIONS: u32 = 256;
/// Payloads begin at multiples of this many bytes.
pub const ALIGNMENT: u64 = 64;
/// Bytes of one entry of the section table.
pub(crate) const ENTRY_BYTES: usize = 48;
/// Encoding of a section whose payload is stored as it is.
pub const RAW: u16 = 0;
/// Flag of a section that readers must understand.
pub const CRITICAL: u32 = 1;

/// A section's name within a file: unique, and the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SectionId {
    /// What it holds; see [`kind`].
    pub kind: u32,
    /// Which of its kind, for example the number of a level.
    pub index: u32,
}

impl SectionId {
    /// The first (usually only) section of a kind.
    #[must_use]
    pub const fn first(kind: u32) -> Self {
        Self { kind, index: 0 }
    }
}

impl fmt::Display for SectionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match kind::name(self.kind) {
            Some(name) => write!(f, "section {name}")?,
            None => write!(f, "section of kind {:#x}", self.kind)?,
        }
        match (self.kind, self.index) {
            (kind::GRID, level) => write!(f, " level {level}"),
            (kind::NETWORK, number) => write!(f, " tensor {number}"),
            (_, 0) => Ok(()),
            (_, index) => write!(f, " index {index}"),
        }
    }
}

/// A section table entry with the payload it points to.
#[derive(Clone, Copy)]
pub struct Section<'a> {
    /// Kind and index.
    pub id: SectionId,
    /// Version of the payload's own layout.
    pub version: u16,
    /// How the payload is stored: [`RAW`], or an encoding of packed files.
    pub encoding: u16,
    /// [`CRITICAL`], and bits that a newer minor version may define.
    pub flags: u32,
    /// Where the payload begins, bytes from the start of the file.
    pub offset: u64,
    /// Bytes of the payload once decoded.
    pub decoded_length: u64,
    /// CRC-32 of the stored payload.
    pub checksum: u32,
    /// The stored payload.
    pub bytes: &'a [u8],
}

impl fmt::Debug for Section<'_> {
    // The payload may be megabytes long; print its length.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Section")
            .field("id", &self.id)
            .field("version", &self.version)
            .field("encoding", &self.encoding)
            .field("flags", &self.flags)
            .field("offset", &self.offset)
            .field("length", &self.bytes.len())
            .finish_non_exhaustive()
    }
}

impl Section<'_> {
    /// Whether a reader that does not understand the section must refuse the file.
    #[must_use]
    pub const fn is_critical(&self) -> bool {
        self.flags & CRITICAL != 0
    }

    /// Compares the payload with its checksum. O(bytes).
    ///
    /// # Errors
    /// [`FormatError::Checksum`].
    pub fn verify(&self) -> Result<(), FormatError> {
        let found = checksum::hash(self.bytes);
        if found != self.checksum {
            let (section, expected) = (self.id, self.checksum);
            return Err(FormatError::Checksum { section, expected, found });
        }
        Ok(())
    }
}

/// The fields of a section table entry, in file order.
pub(crate) struct Entry {
    pub(crate) id: SectionId,
    pub(crate) version: u16,
    pub(crate) encoding: u16,
    pub(crate) flags: u32,
    pub(crate) offset: u64,
    pub(crate) stored_length: u64,
    pub(crate) decoded_length: u64,
    pub(crate) checksum: u32,
}

impl Entry {
    pub(crate) fn read(bytes: &[u8; ENTRY_BYTES]) -> Self {
        Self {
            id: SectionId { kind: u32_at(bytes, 0), index: u32_at(bytes, 4) },
            version: u16_at(bytes, 8),
            encoding: u16_at(bytes, 10),
            flags: u32_at(bytes, 12),
            offset: u64_at(bytes, 16),
            stored_length: u64_at(bytes, 24),
            decoded_length: u64_at(bytes, 32),
            checksum: u32_at(bytes, 40),
        }
    }

    pub(crate) fn to_bytes(&self) -> [u8; ENTRY_BYTES] {
        let mut bytes = [0; ENTRY_BYTES];
        bytes[0..4].copy_from_slice(&self.id.kind.to_le_bytes());
        bytes[4..8].copy_from_slice(&self.id.index.to_le_bytes());
        bytes[8..10].copy_from_slice(&self.version.to_le_bytes());
        bytes[10..12].copy_from_slice(&self.encoding.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.flags.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.offset.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.stored_length.to_le_bytes());
        bytes[32..40].copy_from_slice(&self.decoded_length.to_le_bytes());
        bytes[40..44].copy_from_slice(&self.checksum.to_le_bytes());
        bytes
    }
}
