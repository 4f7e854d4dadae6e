//! A zip archive: `NAME/data.pkl`, and each storage as `NAME/data/KEY`.
//!
//! Torch stores without compressing. That is all that is read, so no entry can
//! unpack to more than it is, and tensors can stay where they are.

use std::collections::HashMap;
use std::format;
use std::string::{String, ToString as _};

use super::part;
use crate::import::ImportError;
use crate::import::archive::Entry;
use crate::import::budget::Budget;
use crate::import::error::shown;
use crate::import::pickle;
use crate::import::tree::Tree;

const PICKLE: &str = "/data.pkl";

/// Whether an archive is one of torch's.
pub(in crate::import) fn is_torch(entries: &[Entry<'_>]) -> bool {
    entries.iter().any(|entry| entry.name.ends_with(PICKLE))
}

pub(in crate::import) fn read<'a>(
    entries: &[Entry<'a>],
    mut budget: Budget,
) -> Result<Tree<'a>, ImportError> {
    // The names once more, and a table that doubles.
    entries.iter().try_for_each(|entry| budget.spend(entry.name.len()))?;
    budget.spend_on::<(String, &[u8], u64)>(entries.len())?;
    let entries = stored(entries)?;
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
fn stored<'a>(entries: &[Entry<'a>]) -> Result<HashMap<String, &'a [u8]>, ImportError> {
    let mut stored = HashMap::new();
    for entry in entries {
        let packed = || ImportError::Packed { entry: shown(&entry.name) };
        if stored.insert(entry.name.clone(), entry.stored()?.ok_or_else(packed)?).is_some() {
            return Err(ImportError::Duplicate(shown(&entry.name)));
        }
    }
    Ok(stored)
}
