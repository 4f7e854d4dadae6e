//! Zip archives: what `torch.save` and `numpy.savez` write their entries into.

use std::borrow::Cow;
use std::format;
use std::string::{String, ToString as _};
use std::vec::Vec;

use flate2::{Decompress, FlushDecompress, Status};
use rawzip::{CompressionMethod, ZipArchive, ZipFileHeaderRecord, ZipSliceArchive};

use super::ImportError;
use super::budget::Budget;
use super::error::shown;

/// The first bytes of an archive that is not empty.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// An entry, as it lies in the archive.
pub(super) struct Entry<'a> {
    pub(super) name: String,
    bytes: &'a [u8],
    packing: Packing,
    crc32: u32,
}

/// How an entry's contents lie in the archive.
enum Packing {
    Stored,
    /// To so many bytes.
    Deflated(u64),
    /// Encrypted, or by another method.
    Other,
}

impl<'a> Entry<'a> {
    /// The contents, if they lie in the archive as they are.
    pub(super) fn stored(&self) -> Result<Option<&'a [u8]>, ImportError> {
        match self.packing {
            Packing::Stored => self.check(self.bytes).map(|()| Some(self.bytes)),
            Packing::Deflated(_) | Packing::Other => Ok(None),
        }
    }

    /// The contents, unpacked if need be.
    pub(super) fn unpacked(&self, budget: &mut Budget) -> Result<Cow<'a, [u8]>, ImportError> {
        let Packing::Deflated(size) = self.packing else {
            let stored = self.stored()?.map(Cow::Borrowed);
            let refused = "encrypted, or compressed in a way that numpy has none of";
            return stored.ok_or_else(|| self.refuse(refused));
        };
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        budget.spend(size)?;
        let mut unpacked = Vec::with_capacity(size);
        let status = Decompress::new(false).decompress_vec(
            self.bytes,
            &mut unpacked,
            FlushDecompress::Finish,
        );
        if !matches!(status, Ok(Status::StreamEnd)) || unpacked.len() != size {
            return Err(self.refuse(&format!("it does not unpack to {size} bytes")));
        }
        self.check(&unpacked)?;
        Ok(unpacked.into())
    }

    fn refuse(&self, problem: &str) -> ImportError {
        ImportError::Archive(format!("the entry {}: {problem}", shown(&self.name)))
    }

    /// Compares with the checksum in the archive, which torch can be told to leave out:
    /// it then writes zeros.
    fn check(&self, contents: &[u8]) -> Result<(), ImportError> {
        let (expected, found) = (self.crc32, crc32fast::hash(contents));
        if expected == 0 || expected == found {
            return Ok(());
        }
        Err(ImportError::Checksum { entry: shown(&self.name), expected, found })
    }
}

/// Every entry, in the order of the archive's table.
pub(super) fn entries<'a>(
    bytes: &'a [u8],
    budget: &mut Budget,
) -> Result<Vec<Entry<'a>>, ImportError> {
    let archive = ZipArchive::from_slice(bytes).map_err(unreadable)?;
    let mut records = archive.entries();
    let mut entries = Vec::new();
    let mut in_entries = 0;
    while let Some(record) = records.next_entry().map_err(unreadable)? {
        let path = record.file_path();
        budget.spend_on::<Entry<'_>>(1)?;
        // A byte that is no text becomes three.
        budget.spend(3 * path.len())?;
        let name = String::from_utf8_lossy(path.as_bytes()).into_owned();
        let contents = contents(bytes, &archive, &record)?;
        // Each takes time, and many could lie in the same place.
        in_entries += contents.len();
        if in_entries > bytes.len() {
            return Err(ImportError::Archive("its entries overlap".to_string()));
        }
        let (packing, crc32) = (packing(&record), record.crc32());
        entries.push(Entry { name, bytes: contents, packing, crc32 });
    }
    Ok(entries)
}

fn packing(record: &ZipFileHeaderRecord<'_>) -> Packing {
    let size = record.uncompressed_size_hint();
    match record.compression_method() {
        _ if record.flags().is_encrypted() => Packing::Other,
        CompressionMethod::STORE if record.compressed_size_hint() == size => Packing::Stored,
        CompressionMethod::DEFLATE => Packing::Deflated(size),
        _ => Packing::Other,
    }
}

fn contents<'a>(
    bytes: &'a [u8],
    archive: &ZipSliceArchive<&'a [u8]>,
    record: &ZipFileHeaderRecord<'_>,
) -> Result<&'a [u8], ImportError> {
    let entry = archive.get_entry(record.wayfinder()).map_err(unreadable)?;
    let (start, end) = entry.compressed_data_range();
    let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
    range
        .and_then(|(start, end)| bytes.get(start..end))
        .ok_or(ImportError::CutOff("the zip archive"))
}

fn unreadable(error: rawzip::Error) -> ImportError {
    ImportError::Archive(error.to_string())
}
