//! Sections to a file.

use alloc::borrow::Cow;
use alloc::vec::Vec;

use super::WriteError;
use crate::FormatError;
use crate::container::header::seal;
use crate::container::section::{ENTRY_BYTES, Entry};
use crate::container::{
    ALIGNMENT, CRITICAL, Container, HEADER_BYTES, Header, MAJOR, MAX_SECTIONS, MINOR, RAW, Section,
    SectionId, checksum,
};

/// Collects sections and lays them out as a file.
///
/// The same sections give the same bytes, in whatever order they were added.
/// Programs number their own kinds from
/// [`kind::PROGRAM`](crate::container::kind::PROGRAM); sections that are not
/// critical leave the model in the file readable by everyone.
#[derive(Debug, Default)]
pub struct ContainerWriter<'a> {
    sections: Vec<Pending<'a>>,
}

#[derive(Debug)]
struct Pending<'a> {
    id: SectionId,
    version: u16,
    critical: bool,
    encoding: u16,
    decoded_length: u64,
    payload: Cow<'a, [u8]>,
}

impl<'a> ContainerWriter<'a> {
    /// A file without sections.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a raw section.
    pub fn add(
        &mut self,
        id: SectionId,
        version: u16,
        critical: bool,
        payload: impl Into<Cow<'a, [u8]>>,
    ) {
        let payload = payload.into();
        let (encoding, decoded_length) = (RAW, payload.len() as u64);
        self.sections.push(Pending { id, version, critical, encoding, decoded_length, payload });
    }

    /// Adds a section of another file, as it is.
    pub(crate) fn add_section(&mut self, section: &Section<'a>) {
        let Section { id, version, encoding, decoded_length, bytes, .. } = *section;
        let (critical, payload) = (section.is_critical(), bytes.into());
        self.sections.push(Pending { id, version, critical, encoding, decoded_length, payload });
    }

    /// Adds a section whose payload stands for so many bytes.
    pub(crate) fn add_packed(
        &mut self,
        (id, version, critical): (SectionId, u16, bool),
        encoding: u16,
        decoded_length: u64,
        payload: Vec<u8>,
    ) {
        let payload = payload.into();
        self.sections.push(Pending { id, version, critical, encoding, decoded_length, payload });
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// [`WriteError::Twice`], or [`WriteError::Unreadable`] for too many sections.
    pub fn finish(mut self) -> Result<Vec<u8>, WriteError> {
        self.sections.sort_by_key(|section| section.id);
        if let Some(pair) = self.sections.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(WriteError::Twice(pair[0].id));
        }
        let n_sections = u32::try_from(self.sections.len()).unwrap_or(u32::MAX);
        if n_sections > MAX_SECTIONS {
            return Err(FormatError::TooManySections { found: n_sections }.into());
        }
        let table_end = HEADER_BYTES + self.sections.len() * ENTRY_BYTES;
        let mut end = table_end as u64;
        let mut head = Vec::with_capacity(table_end);
        head.extend_from_slice(&[0; HEADER_BYTES]);
        for section in &self.sections {
            let length = section.payload.len() as u64;
            let entry = Entry {
                id: section.id,
                version: section.version,
                encoding: section.encoding,
                flags: if section.critical { CRITICAL } else { 0 },
                offset: end.next_multiple_of(ALIGNMENT),
                stored_length: length,
                decoded_length: section.decoded_length,
                checksum: checksum::hash(&section.payload),
            };
            head.extend_from_slice(&entry.to_bytes());
            end = entry.offset + length;
        }
        let header = Header { version: [MAJOR, MINOR], n_sections, file_length: end, checksum: 0 };
        head[..HEADER_BYTES].copy_from_slice(&header.to_bytes());
        seal(&mut head);

        let mut file = head;
        file.reserve_exact(end as usize - table_end);
        for section in &self.sections {
            file.resize(file.len().next_multiple_of(ALIGNMENT as usize), 0);
            file.extend_from_slice(&section.payload);
        }
        debug_assert!(Container::open(&file).is_ok(), "what is written can be opened");
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::kind;

    const A: SectionId = SectionId { kind: kind::PROGRAM, index: 0 };
    const B: SectionId = SectionId { kind: kind::PROGRAM, index: 1 };

    #[test]
    fn order_of_adding_does_not_matter() {
        let (mut forth, mut back) = (ContainerWriter::new(), ContainerWriter::new());
        forth.add(A, 1, false, &b"one"[..]);
        forth.add(B, 2, true, Vec::new());
        back.add(B, 2, true, Vec::new());
        back.add(A, 1, false, &b"one"[..]);
        let bytes = forth.finish().unwrap();
        assert_eq!(back.finish().as_ref(), Ok(&bytes));
        // 32 + 2 * 48 = 128, "one" at 128, the empty section at 192.
        assert_eq!(bytes.len(), 192);
        let container = Container::open(&bytes).unwrap();
        container.verify().unwrap();
        assert_eq!(container.sections().len(), 2);
        assert_eq!(container.find(A).unwrap().bytes, b"one");
        let b = container.find(B).unwrap();
        assert_eq!((b.offset, b.version, b.is_critical()), (192, 2, true));
        assert!(container.find(SectionId { kind: 3, index: 0 }).is_none());
    }

    #[test]
    fn an_empty_file_is_a_file() {
        let bytes = ContainerWriter::new().finish().unwrap();
        assert_eq!(bytes.len(), HEADER_BYTES);
        assert_eq!(Container::open(&bytes).unwrap().sections().len(), 0);
    }

    #[test]
    fn refuses_twice_and_too_many() {
        let mut writer = ContainerWriter::new();
        writer.add(A, 1, false, Vec::new());
        writer.add(A, 1, false, Vec::new());
        assert_eq!(writer.finish(), Err(WriteError::Twice(A)));
        let mut writer = ContainerWriter::new();
        for index in 0..=MAX_SECTIONS {
            writer.add(SectionId { kind: kind::PROGRAM, index }, 1, false, Vec::new());
        }
        let error = FormatError::TooManySections { found: MAX_SECTIONS + 1 };
        assert_eq!(writer.finish(), Err(WriteError::Unreadable(error)));
    }
}
