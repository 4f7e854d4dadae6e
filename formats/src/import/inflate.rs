//! Files that are compressed as a whole: instant-ngp's `.ingp`, by zlib or gzip.

use std::borrow::Cow;
use std::io::{Read, copy};
use std::string::ToString as _;
use std::vec::Vec;

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use super::ImportError;
use super::error::shown;

/// Most bytes of what is unpacked, beyond [`MOST_TIMES`] the file's own.
const MOST: usize = 64 << 20;
/// Weights hardly shrink; untrained tables and empty cells do.
const MOST_TIMES: usize = 32;

/// The contents of a compressed file; other files as they are. The first bytes decide,
/// because both kinds have the same name.
///
/// # Errors
/// [`ImportError::Inflate`], and [`ImportError::TooMuch`] for more than 64 MB and 32 times
/// the file.
pub fn inflate(bytes: &[u8]) -> Result<Cow<'_, [u8]>, ImportError> {
    match bytes {
        [0x1f, 0x8b, ..] => unpack(bytes.len(), MultiGzDecoder::new(bytes)),
        // Deflate with a window of 32 kB, the only one in use; the two bytes are a multiple
        // of 31.
        [0x78, flags, ..] if u16::from_be_bytes([0x78, *flags]).is_multiple_of(31) => {
            unpack(bytes.len(), ZlibDecoder::new(bytes))
        }
        _ => Ok(Cow::Borrowed(bytes)),
    }
}

fn unpack<'a>(packed: usize, decoder: impl Read) -> Result<Cow<'a, [u8]>, ImportError> {
    let limit = packed.saturating_mul(MOST_TIMES).saturating_add(MOST);
    let mut unpacked = Vec::new();
    // Reading one byte past the limit detects that there is more.
    copy(&mut decoder.take(limit as u64 + 1), &mut unpacked)
        .map_err(|error| ImportError::Inflate(shown(&error.to_string())))?;
    if unpacked.len() > limit {
        return Err(ImportError::TooMuch { what: "bytes of the unpacked file", limit });
    }
    unpacked.shrink_to_fit();
    Ok(Cow::Owned(unpacked))
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::vec;

    use flate2::Compression;
    use flate2::write::{GzEncoder, ZlibEncoder};

    use super::*;

    #[test]
    fn zlib_gzip_and_neither() {
        let text = b"the same bytes again, the same bytes again".as_slice();
        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
        let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
        zlib.write_all(text).unwrap();
        gzip.write_all(text).unwrap();
        for packed in [zlib.finish().unwrap(), gzip.finish().unwrap()] {
            assert_eq!(inflate(&packed).unwrap(), text);
            for end in 3..packed.len() {
                assert!(inflate(&packed[..end]).is_err(), "{end} of {}", packed.len());
            }
        }
        assert!(matches!(inflate(text), Ok(Cow::Borrowed(_))));
        assert!(inflate(&[]).is_ok() && inflate(&[0x78]).is_ok() && inflate(b"x.").is_ok());
    }

    #[test]
    fn a_bomb_is_stopped() {
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        (0..80).for_each(|_| packed.write_all(&vec![0; 1 << 20]).unwrap());
        let packed = packed.finish().unwrap();
        assert!(matches!(inflate(&packed), Err(ImportError::TooMuch { .. })));
    }
}
