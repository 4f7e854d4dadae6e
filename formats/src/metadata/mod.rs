//! The small postcard sections, one file a subject.
//!
//! postcard is positional: a struct named `…V1` here is a promise about bytes
//! and never changes. A change is a new struct under a new section version.
//! The tests hold the bytes of each.

pub(crate) mod about;
#[cfg(feature = "contracted")]
mod contracted;
pub(crate) mod field;
#[cfg(feature = "ndc")]
mod ndc;
pub(crate) mod photographs;
pub(crate) mod space;
pub(crate) mod world;

use serde::{Deserialize, Serialize};

use crate::FormatError;
use crate::container::{Section, SectionId};

/// Most bytes a metadata section may have.
pub const MAX_METADATA_BYTES: usize = 1 << 16;

/// Version of every metadata section so far.
pub(crate) const V1: u16 = 1;

/// The fields of one metadata section, taken from front to back.
pub(crate) struct Fields<'a> {
    section: SectionId,
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    /// Checks length and checksum. Metadata is short and everything else depends on it, so
    /// it is never read unchecked.
    pub(crate) fn open(section: &Section<'a>) -> Result<Self, FormatError> {
        let (id, bytes) = (section.id, section.bytes);
        if bytes.len() > MAX_METADATA_BYTES {
            return Err(FormatError::MetadataLength {
                section: id,
                limit: MAX_METADATA_BYTES as u64,
                found: bytes.len() as u64,
            });
        }
        section.verify()?;
        Ok(Self { section: id, rest: bytes })
    }

    /// The next value.
    pub(crate) fn take<T: Deserialize<'a>>(&mut self) -> Result<T, FormatError> {
        let (value, rest) = postcard::take_from_bytes(self.rest)
            .map_err(|_| FormatError::Metadata(self.section))?;
        self.rest = rest;
        Ok(value)
    }

    /// Checks that nothing follows.
    pub(crate) fn finish(self) -> Result<(), FormatError> {
        if self.rest.is_empty() { Ok(()) } else { Err(FormatError::Metadata(self.section)) }
    }

    /// Checks that a field may have the value it has.
    pub(crate) fn check(&self, field: &'static str, holds: bool) -> Result<(), FormatError> {
        if holds { Ok(()) } else { Err(FormatError::Value { section: self.section, field }) }
    }

    /// Checks that every number of a field is finite.
    pub(crate) fn finite(&self, field: &'static str, values: &[f32]) -> Result<(), FormatError> {
        self.check(field, values.iter().all(|v| v.is_finite()))
    }

    /// Checks that a text can be printed: it must not control a terminal.
    pub(crate) fn text(&self, field: &'static str, text: &str) -> Result<(), FormatError> {
        self.check(field, !text.chars().any(char::is_control))
    }

    /// The error of a code that no arm of a match knows.
    pub(crate) fn unknown(&self, field: &'static str, found: u8) -> FormatError {
        FormatError::UnknownCode { section: self.section, field, found: found.into() }
    }
}

/// Appends a metadata value to bytes; `None` where it has none.
pub(crate) fn append<W: Extend<u8>>(bytes: W, value: &impl Serialize) -> Option<W> {
    postcard::to_extend(value, bytes).ok()
}

/// A section as tests build it: in memory, with a right checksum.
#[cfg(test)]
pub(crate) fn test_section(kind: u32, bytes: &[u8]) -> Section<'_> {
    Section {
        id: SectionId::first(kind),
        version: V1,
        encoding: crate::container::RAW,
        flags: crate::container::CRITICAL,
        offset: 0,
        decoded_length: bytes.len() as u64,
        checksum: crate::container::checksum::hash(bytes),
        bytes,
    }
}

/// The bytes of a metadata value, for tests.
#[cfg(test)]
pub(crate) fn encode(value: &impl Serialize) -> alloc::vec::Vec<u8> {
    append(alloc::vec::Vec::new(), value).unwrap()
}
