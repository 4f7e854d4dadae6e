//! `.npy`: an array of numbers, or of objects (which is a pickle).
//!
//! `\x93NUMPY`, major, minor, the header's length (u16, from version 2 on u32, little
//! endian), the header (a Python dictionary as text: `descr`, `fortran_order`, `shape`),
//! then the contents.

use std::borrow::Cow;
use std::format;
use std::string::String;
use std::vec;
use std::vec::Vec;

use super::ImportError;
use super::budget::Budget;
use super::error::shown;
use super::pickle::{self, NumpyKind, NumpyType};
use super::tensor::{MAX_RANK, Numbers, Placement, Storage, Tensor};
use super::tree::{Leaf, Tree};

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";
/// What errors call the header.
const HEADER: &str = "the header of .npy";

pub(super) fn read(bytes: &[u8], mut budget: Budget) -> Result<Tree<'_>, ImportError> {
    let (header, contents) = open(bytes)?;
    match header.numbers.kind {
        NumpyKind::Object => {
            let pickle = pickle::read(contents, 0, &mut budget)?;
            if pickle.end < contents.len() {
                return Err(ImportError::Trailing { bytes: contents.len() - pickle.end });
            }
            pickle.flatten(&mut budget, false, |storage| {
                Err(ImportError::MissingEntry(shown(storage.key)))
            })
        }
        _ => {
            let tensor = header.tensor(Storage::File(contents), contents.len())?;
            Tree::new(vec![(String::new(), Leaf::Tensor(tensor))])
        }
    }
}

impl<'a> Tensor<'a> {
    /// Reads what `numpy.save` writes of an array of numbers: `.npy` of versions 1 to 3, in
    /// either order of bytes and of indices.
    ///
    /// # Errors
    /// What was found and what was expected; see [`ImportError`].
    pub fn from_npy(bytes: &'a [u8]) -> Result<Self, ImportError> {
        if !bytes.starts_with(MAGIC) {
            let problem = "it does not begin with \\x93NUMPY".into();
            return Err(ImportError::Header { header: HEADER, problem });
        }
        let (header, contents) = open(bytes)?;
        header.tensor(Storage::File(contents), contents.len())
    }
}

/// An array of numbers, which stays in the file where it lies there as it is.
pub(super) fn array<'a>(
    bytes: Cow<'a, [u8]>,
    budget: &mut Budget,
) -> Result<Tensor<'a>, ImportError> {
    match bytes {
        Cow::Borrowed(bytes) => Tensor::from_npy(bytes),
        Cow::Owned(bytes) => {
            let (header, contents) = open(&bytes)?;
            budget.spend(contents.len())?;
            header.tensor(Storage::Decoded(contents.into()), contents.len())
        }
    }
}

/// What the header says, and the contents.
fn open(bytes: &[u8]) -> Result<(Header<'_>, &[u8]), ImportError> {
    let (header, contents) = split(bytes)?;
    let refuse = |problem| ImportError::Header { header: HEADER, problem };
    Ok((parse(header).map_err(refuse)?, contents))
}

/// Header and contents.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), ImportError> {
    let header = HEADER;
    let cut_off = || ImportError::CutOff(header);
    let (version, rest) = bytes.split_at_checked(MAGIC.len() + 2).ok_or_else(cut_off)?;
    let (length, rest) = match version[MAGIC.len()] {
        1 => {
            let (length, rest) = rest.split_first_chunk().ok_or_else(cut_off)?;
            (u16::from_le_bytes(*length).into(), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk().ok_or_else(cut_off)?;
            (u32::from_le_bytes(*length) as usize, rest)
        }
        other => {
            let problem = format!("format version {other} where 1 to 3 were expected");
            return Err(ImportError::Header { header, problem });
        }
    };
    let (text, contents) = rest.split_at_checked(length).ok_or_else(cut_off)?;
    let problem = |_| ImportError::Header { header, problem: "not a text in UTF-8".into() };
    Ok((core::str::from_utf8(text).map_err(problem)?, contents))
}

struct Header<'a> {
    descr: &'a str,
    numbers: NumpyType,
    fortran: bool,
    shape: Vec<usize>,
}

impl Header<'_> {
    /// The numbers that fill a storage of so many bytes.
    fn tensor<'a>(&self, storage: Storage<'a>, bytes: usize) -> Result<Tensor<'a>, ImportError> {
        let NumpyType { kind: NumpyKind::Number(element), big_endian } = self.numbers else {
            return Err(ImportError::ElementType(shown(self.descr)));
        };
        let uncountable = "its shape has more numbers than can be counted";
        let tensor = Placement::contiguous(&self.shape, self.fortran)
            .ok_or(uncountable)
            .and_then(|placement| Tensor::new(Numbers { element, big_endian }, placement, storage))
            .map_err(|problem| ImportError::Tensor { name: String::new(), problem })?;
        match bytes - tensor.len() * element.size() {
            0 => Ok(tensor),
            bytes => Err(ImportError::Trailing { bytes }),
        }
    }
}

fn parse(header: &str) -> Result<Header<'_>, String> {
    let descr = value_of(header, "descr")?;
    let descr = quoted(descr).ok_or_else(|| format!("values of type {}", shown(descr)))?;
    let fortran = match value_of(header, "fortran_order")? {
        text if text.starts_with("True") => true,
        text if text.starts_with("False") => false,
        other => return Err(format!("fortran_order {}", shown(other))),
    };
    let shape = value_of(header, "shape")?;
    let shape = dimensions(shape).ok_or_else(|| format!("shape {}", shown(shape)))?;
    Ok(Header { descr, numbers: NumpyType::parse(descr), fortran, shape })
}

/// What follows a key of the header.
fn value_of<'h>(header: &'h str, key: &str) -> Result<&'h str, String> {
    let at = [format!("'{key}'"), format!("\"{key}\"")].iter().find_map(|quoted| {
        let (_, rest) = header.split_once(quoted.as_str())?;
        rest.trim_start().strip_prefix(':')
    });
    at.map(str::trim_start).ok_or_else(|| format!("{key} is missing"))
}

/// The text between the quotes that it begins with.
fn quoted(text: &str) -> Option<&str> {
    let quote = text.chars().next().filter(|quote| matches!(quote, '\'' | '"'))?;
    Some(text[1..].split_once(quote)?.0)
}

/// `(20, 17)`, `(5,)`, `()`; Python 2 wrote some as `20L`.
fn dimensions(shape: &str) -> Option<Vec<usize>> {
    let inside = shape.strip_prefix('(')?.split_once(')')?.0.trim();
    let inside = inside.strip_suffix(',').unwrap_or(inside);
    if inside.is_empty() {
        return Some(Vec::new());
    }
    inside
        .split(',')
        .take(MAX_RANK + 1)
        .map(|n| n.trim().trim_end_matches('L').parse().ok())
        .collect()
}
