//! A file as a sequence of sections.

pub(crate) mod checksum;
pub(crate) mod header;
pub(crate) mod section;

use core::fmt;

use header::head_checksum;
pub use header::{HEADER_BYTES, Header, MAGIC, MAJOR, MINOR};
pub use section::{ALIGNMENT, CRITICAL, MAX_SECTIONS, RAW, Section, SectionId, kind};
use section::{ENTRY_BYTES, Entry};

use crate::FormatError;

/// A file whose header and section table have been checked. Borrows the bytes.
///
/// Knows nothing of models: a program that keeps sections of its own in a file
/// (kinds from [`kind::PROGRAM`](kind::PROGRAM)) finds them here.
#[derive(Clone, Copy)]
pub struct Container<'a> {
    header: Header,
    bytes: &'a [u8],
    table: &'a [[u8; ENTRY_BYTES]],
}

impl fmt::Debug for Container<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Container").field("header", &self.header).finish_non_exhaustive()
    }
}

impl<'a> Container<'a> {
    /// Checks header, checksum of the table, and that the sections fill the
    /// file in order without overlap. O(sections).
    ///
    /// # Errors
    /// The errors of [`Header::read`]; [`FormatError::Length`],
    /// [`FormatError::HeaderChecksum`], [`FormatError::Order`],
    /// [`FormatError::Offset`], [`FormatError::Bounds`],
    /// [`FormatError::DecodedLength`].
    pub fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let header = Header::read(bytes)?;
        let length = bytes.len() as u64;
        let table_end = header.table_end();
        if header.file_length != length || bytes.len() < table_end {
            let expected = header.file_length.max(table_end as u64);
            return Err(FormatError::Length { expected, found: length });
        }
        let found = head_checksum(&bytes[..table_end]);
        if found != header.checksum {
            return Err(FormatError::HeaderChecksum { expected: header.checksum, found });
        }
        let (table, _) = bytes[HEADER_BYTES..table_end].as_chunks();
        let mut end = table_end as u64;
        let mut before: Option<SectionId> = None;
        for entry in table {
            let entry = Entry::read(entry);
            let section = entry.id;
            if before.is_some_and(|before| before >= section) {
                return Err(FormatError::Order(section));
            }
            before = Some(section);
            // `end` is at most the length of a slice: rounding up cannot overflow.
            let expected = end.next_multiple_of(ALIGNMENT);
            if entry.offset != expected {
                return Err(FormatError::Offset { section, expected, found: entry.offset });
            }
            let available = length.saturating_sub(entry.offset);
            if entry.offset > length || entry.stored_length > available {
                let found = entry.stored_length;
                return Err(FormatError::Bounds { section, found, available });
            }
            if entry.encoding == RAW && entry.decoded_length != entry.stored_length {
                let (expected, found) = (entry.stored_length, entry.decoded_length);
                return Err(FormatError::DecodedLength { section, expected, found });
            }
            end = entry.offset + entry.stored_length;
        }
        if end != length {
            return Err(FormatError::Length { expected: end, found: length });
        }
        Ok(Self { header, bytes, table })
    }

    /// The header.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    /// The sections in the order of the file.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = Section<'a>> + use<'a> {
        let bytes = self.bytes;
        self.table.iter().map(move |entry| section(bytes, &Entry::read(entry)))
    }

    /// The section of that kind and index, if it is there.
    #[must_use]
    pub fn find(&self, id: SectionId) -> Option<Section<'a>> {
        let at = self.table.binary_search_by_key(&id, |entry| Entry::read(entry).id).ok()?;
        Some(section(self.bytes, &Entry::read(&self.table[at])))
    }

    /// Compares every payload with its checksum, and every byte between
    /// payloads with zero. O(bytes).
    ///
    /// # Errors
    /// [`FormatError::Checksum`] or [`FormatError::Padding`].
    pub fn verify(&self) -> Result<(), FormatError> {
        let mut end = self.header.table_end();
        for section in self.sections() {
            // `open` has checked that the offset lies inside the file.
            let start = section.offset as usize;
            if self.bytes[end..start].iter().any(|byte| *byte != 0) {
                return Err(FormatError::Padding(section.id));
            }
            section.verify()?;
            end = start + section.bytes.len();
        }
        Ok(())
    }
}

/// The section of a table entry that `open` has checked.
fn section<'a>(bytes: &'a [u8], entry: &Entry) -> Section<'a> {
    let start = entry.offset as usize;
    Section {
        id: entry.id,
        version: entry.version,
        encoding: entry.encoding,
        flags: entry.flags,
        offset: entry.offset,
        decoded_length: entry.decoded_length,
        checksum: entry.checksum,
        bytes: &bytes[start..start + entry.stored_length as usize],
    }
}
