//! `.npz`: a zip archive of `NAME.npy`, as `numpy.savez` stores it and
//! `numpy.savez_compressed` deflates it.

use std::boxed::Box;
use std::string::ToString as _;
use std::vec::Vec;

use super::ImportError;
use super::archive::Entry;
use super::budget::Budget;
use super::error::shown;
use super::npy;
use super::tree::{Leaf, Tree};

/// What an array's entry ends with, beyond its name.
const ARRAY: &str = ".npy";

/// What unpacking an entry takes beside its contents, more than enough.
const INFLATER: usize = 1 << 16;

/// Whether an archive is one of arrays.
pub(super) fn is_npz(entries: &[Entry<'_>]) -> bool {
    entries.iter().any(|entry| entry.name.ends_with(ARRAY))
}

/// The arrays by their names; other entries are ignored.
pub(super) fn read<'a>(entries: &[Entry<'a>], mut budget: Budget) -> Result<Tree<'a>, ImportError> {
    budget.spend(INFLATER)?;
    let mut leaves = Vec::new();
    for entry in entries {
        let Some(name) = entry.name.strip_suffix(ARRAY) else { continue };
        let contents = entry.unpacked(&mut budget)?;
        let tensor = npy::array(contents, &mut budget).map_err(|error| ImportError::Entry {
            entry: shown(&entry.name),
            error: Box::new(error),
        })?;
        budget.spend_on::<(&str, Leaf<'_>)>(1)?;
        budget.spend(name.len())?;
        leaves.push((name.to_string(), Leaf::Tensor(tensor)));
    }
    Tree::new(leaves)
}
