//! A zip archive: `NAME/data.pkl`, and each storage as `NAME/data/KEY`.
//!
//! Torch stores without compressing. That is all that is read, so no entry can
//! unpack to more than it is, and tensors can stay where they are.

use std::collections::HashMap;
use std::format;
use std::string::{String, ToString as _};

use rawzip::{CompressionMethod, ZipArchive, ZipFileHeaderRecord, ZipSliceArchive};

use super::part;
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::import::error::shown;
use crate::import::pickle;
use crate::import::tree::Tree;

/// The first bytes of an archive that is not empty.
pub(in crate::import) const MAGIC: &[u8] = b"PK\x03\x04";

const PICKLE: &str = "/data.pkl";

pub(in crate::import) fn read(bytes: &[u8], mut budget: Budget) -> Result<Tree<'_>, ImportError> {
    let entries = entries(bytes, &mut budget)?;
    let mut pickles = entries.keys().filter_map(|name| name.strip_suffix(PICKLE));
    let folder = pickles.next().ok_or_else(|| ImportError::MissingEntry("data.pkl".to_string()))?;
    if pickles.next().is_some() {
        return Err(ImportError::Duplicate("data.pkl".to_string()));
    }
    let entry = |name: &str| {
        let path = format!("{folder}/{name}");
        entries.get(&path).copied().ok_or_else(|| ImportError::MissingEntry(shown(&path)))
    };
    let big_endian = match entry("byteorder") {
        Err(_) | Ok(b"little") => false,
        Ok(b"big") => true,
        Ok(other) => return Err(ImportError::ByteOrder(shown(&String::from_utf8_lossy(other)))),
    };
    let main = entry("data.pkl")?;
    let pickle = pickle::read(main, 0, &mut budget)?;
    if pickle.end < main.len() {
        return Err(ImportError::Trailing { bytes: main.len() - pickle.end });
    }
    pickle.flatten(&mut budget, big_endian, |storage| {
        part(storage, entry(&format!("data/{}", storage.key))?)
    })
}

/// The bytes of every entry.
fn entries<'a>(
    bytes: &'a [u8],
    budget: &mut Budget,
) -> Result<HashMap<String, &'a [u8]>, ImportError> {
    let archive = ZipArchive::from_slice(bytes).map_err(unreadable)?;
    let mut records = archive.entries();
    let mut entries = HashMap::new();
    let mut in_entries = 0;
    while let Some(record) = records.next_entry().map_err(unreadable)? {
        let path = record.file_path();
        budget.spend_on::<(String, &[u8], u64)>(1)?;
        // A byte that is no text becomes three.
        budget.spend(3 * path.len())?;
        let name = String::from_utf8_lossy(path.as_bytes()).into_owned();
        let contents = contents(bytes, &archive, &record, &name)?;
        // Each takes time, and many could lie in the same place.
        in_entries += contents.len();
        if in_entries > bytes.len() {
            return Err(ImportError::Archive("its entries overlap".to_string()));
        }
        check(contents, record.crc32(), &name)?;
        if entries.insert(name.clone(), contents).is_some() {
            return Err(ImportError::Duplicate(shown(&name)));
        }
    }
    Ok(entries)
}

fn contents<'a>(
    bytes: &'a [u8],
    archive: &ZipSliceArchive<&'a [u8]>,
    record: &ZipFileHeaderRecord<'_>,
    name: &str,
) -> Result<&'a [u8], ImportError> {
    let is_stored = record.compression_method() == CompressionMethod::STORE
        && !record.flags().is_encrypted()
        && record.compressed_size_hint() == record.uncompressed_size_hint();
    if !is_stored {
        return Err(ImportError::Packed { entry: shown(name) });
    }
    let entry = archive.get_entry(record.wayfinder()).map_err(unreadable)?;
    let (start, end) = entry.compressed_data_range();
    let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
    range
        .and_then(|(start, end)| bytes.get(start..end))
        .ok_or(ImportError::CutOff("the zip archive"))
}

/// Compares with the checksum in the archive, which torch can be told to leave out: it
/// then writes zeros.
fn check(contents: &[u8], expected: u32, name: &str) -> Result<(), ImportError> {
    let found = crc32fast::hash(contents);
    if expected == 0 || expected == found {
        return Ok(());
    }
    Err(ImportError::Checksum { entry: shown(name), expected, found })
}

fn unreadable(error: rawzip::Error) -> ImportError {
    ImportError::Archive(error.to_string())
}
