//! The first 32 bytes of a file.

use super::checksum;
use super::section::{ENTRY_BYTES, MAX_SECTIONS};
use crate::FormatError;

/// The first eight bytes of every file. The first byte is lost by a 7-bit
/// channel, the line end is changed by a transfer in text mode, and 0x1a ends
/// the output of tools that print text.
pub const MAGIC: [u8; 8] = *b"\xabPNRF\r\n\x1a";
/// Major version that this build writes, and the only one it reads.
pub const MAJOR: u16 = 1;
/// Minor version that this build writes. Newer ones are read as well.
pub const MINOR: u16 = 0;

/// Bytes before the section table.
pub const HEADER_BYTES: usize = 32;
/// Offset of the header's checksum.
const CHECKSUM_AT: usize = 24;

/// The first [`HEADER_BYTES`] bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Major and minor version of the format.
    pub version: [u16; 2],
    /// Entries in the section table.
    pub n_sections: u32,
    /// Bytes in the whole file.
    pub file_length: u64,
    /// CRC-32 of header and table, these four bytes taken as zero.
    pub checksum: u32,
}

impl Header {
    /// Reads the header from the first bytes of a file. More bytes may follow;
    /// a program that does not know where a file in flash or in a stream ends
    /// finds out from `file_length`.
    ///
    /// # Errors
    /// [`FormatError::NotPnerf`], [`FormatError::TextTransfer`],
    /// [`FormatError::Version`], [`FormatError::Length`] where there are fewer
    /// than [`HEADER_BYTES`], [`FormatError::TooManySections`].
    pub fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let n = bytes.len().min(MAGIC.len());
        let mut found = [0; 8];
        found[..n].copy_from_slice(&bytes[..n]);
        if n == 0 || found[..n] != MAGIC[..n] {
            return Err(if found[1..5] == MAGIC[1..5] {
                FormatError::TextTransfer { found }
            } else {
                FormatError::NotPnerf { found }
            });
        }
        let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
            return Err(FormatError::Length {
                expected: HEADER_BYTES as u64,
                found: bytes.len() as u64,
            });
        };
        let header = Self {
            version: [u16_at(header, 8), u16_at(header, 10)],
            n_sections: u32_at(header, 12),
            file_length: u64_at(header, 16),
            checksum: u32_at(header, CHECKSUM_AT),
        };
        // Another version may give everything after it another meaning.
        if header.version[0] != MAJOR {
            return Err(FormatError::Version { found: header.version });
        }
        if header.n_sections > MAX_SECTIONS {
            return Err(FormatError::TooManySections { found: header.n_sections });
        }
        Ok(header)
    }

    /// Bytes of header and section table. Cannot overflow: the number of
    /// sections is limited.
    #[must_use]
    pub(crate) const fn table_end(&self) -> usize {
        HEADER_BYTES + self.n_sections as usize * ENTRY_BYTES
    }

    /// The header's bytes, with a checksum of zero.
    pub(crate) fn to_bytes(self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..10].copy_from_slice(&self.version[0].to_le_bytes());
        bytes[10..12].copy_from_slice(&self.version[1].to_le_bytes());
        bytes[12..16].copy_from_slice(&self.n_sections.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.file_length.to_le_bytes());
        bytes
    }
}

/// CRC-32 of header and table; `head` is those bytes and no more.
pub(crate) fn head_checksum(head: &[u8]) -> u32 {
    let mut crc = checksum::Hasher::new();
    crc.update(&head[..CHECKSUM_AT]);
    crc.update(&[0; 4]);
    crc.update(&head[CHECKSUM_AT + 4..]);
    crc.finalize()
}

/// Writes the checksum of header and table into the header.
pub(crate) fn seal(head: &mut [u8]) {
    let crc = head_checksum(head);
    head[CHECKSUM_AT..CHECKSUM_AT + 4].copy_from_slice(&crc.to_le_bytes());
}

/// The little-endian number at byte `at`, which the caller knows to be inside.
pub(crate) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// The little-endian number at byte `at`, which the caller knows to be inside.
pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | u32::from(u16_at(bytes, at + 2)) << 16
}

/// The little-endian number at byte `at`, which the caller knows to be inside.
pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_by_what_it_sees() {
        assert_eq!(Header::read(b""), Err(FormatError::NotPnerf { found: [0; 8] }));
        assert_eq!(Header::read(b"GIF89a"), Err(FormatError::NotPnerf { found: *b"GIF89a\0\0" }));
        assert!(matches!(Header::read(b"\xabPNRF\n\x1a\0"), Err(FormatError::TextTransfer { .. })));
        assert!(matches!(Header::read(b"+PNRF\r\n\x1a"), Err(FormatError::TextTransfer { .. })));
        assert_eq!(Header::read(&MAGIC), Err(FormatError::Length { expected: 32, found: 8 }));
    }

    #[test]
    fn major_version_is_refused_and_minor_is_not() {
        let mut bytes = [0; HEADER_BYTES];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8] = 2;
        bytes[10] = 7;
        assert_eq!(Header::read(&bytes), Err(FormatError::Version { found: [2, 7] }));
        bytes[8] = 1;
        assert_eq!(Header::read(&bytes).unwrap().version, [1, 7]);
        bytes[14] = 1;
        assert_eq!(Header::read(&bytes), Err(FormatError::TooManySections { found: 65536 }));
    }
}
