//! One after the other: a pickled magic number, version and system, the pickled
//! object, the pickled list of its storages' keys, then for each storage the number of
//! its elements (`u64`, little endian) and its bytes.
//!
//! Nothing may follow the last storage: the file would hold more than is read.

use std::collections::HashMap;
use std::vec::Vec;

use super::part;
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::import::error::shown;
use crate::import::pickle::{self, Pickle, TorchStorage};
use crate::import::tree::Tree;

/// The magic number as a pickle holds it: LONG1, its length, its bytes.
const MAGIC: &[u8] = b"\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.";

pub(in crate::import) fn is_legacy(bytes: &[u8]) -> bool {
    // Between them is the frame of later protocols.
    bytes.starts_with(&[0x80])
        && bytes.get(2..32.min(bytes.len())).is_some_and(|start| {
            start.starts_with(MAGIC) || start.get(9..).is_some_and(|rest| rest.starts_with(MAGIC))
        })
}

pub(in crate::import) fn read(bytes: &[u8], mut budget: Budget) -> Result<Tree<'_>, ImportError> {
    let mut at = 0;
    let mut next = |budget: &mut Budget| {
        let pickle = pickle::read(bytes, at, budget)?;
        at = pickle.end;
        Ok::<_, ImportError>(pickle)
    };
    let (_magic, version, _system) = (next(&mut budget)?, next(&mut budget)?, next(&mut budget)?);
    if version.integer() != Some(1001) {
        return Err(ImportError::Pickle { at: version.end, expected: "protocol version 1001" });
    }
    let object = next(&mut budget)?;
    let keys = next(&mut budget)?;
    let storages = storages(bytes, &object, &keys, &mut budget)?;
    object.flatten(&mut budget, false, |storage| {
        let stored = storages.get(storage.key);
        part(storage, stored.ok_or_else(|| missing(storage.key))?)
    })
}

/// The bytes of every storage.
fn storages<'a>(
    bytes: &'a [u8],
    object: &Pickle<'a>,
    keys: &Pickle<'a>,
    budget: &mut Budget,
) -> Result<HashMap<&'a str, &'a [u8]>, ImportError> {
    let expected = "a list of the storages' keys";
    let keys_of_file: Vec<&str> =
        keys.texts().ok_or(ImportError::Pickle { at: keys.end, expected })?;
    budget.spend_on::<(&str, TorchStorage<'_>, &[u8])>(keys_of_file.len())?;
    let mut mentioned = HashMap::new();
    for storage in object.storages() {
        let first = *mentioned.entry(storage.key).or_insert(storage);
        // The bytes of one storage can be found only if its mentions agree.
        if (first.element_size(), first.len) != (storage.element_size(), storage.len) {
            return Err(ImportError::Duplicate(shown(storage.key)));
        }
    }
    let mut storages = HashMap::new();
    let mut rest = &bytes[keys.end..];
    for key in keys_of_file {
        let storage = mentioned.get(key).ok_or_else(|| missing(key))?;
        let cut_off = ImportError::CutOff("a storage");
        let (len, after) = rest.split_first_chunk().ok_or(cut_off.clone())?;
        let len = u64::from_le_bytes(*len);
        if len != storage.len as u64 {
            let (expected, found) = (storage.len as u64, len);
            return Err(ImportError::Storage { key: shown(key), expected, found });
        }
        let size = storage.len.checked_mul(storage.element_size()).ok_or(cut_off.clone())?;
        let (stored, after) = after.split_at_checked(size).ok_or(cut_off)?;
        if storages.insert(key, stored).is_some() {
            return Err(ImportError::Duplicate(shown(key)));
        }
        rest = after;
    }
    match rest.len() {
        0 => Ok(storages),
        bytes => Err(ImportError::Trailing { bytes }),
    }
}

fn missing(key: &str) -> ImportError {
    ImportError::MissingEntry(shown(key))
}
