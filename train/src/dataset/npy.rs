//! Reads `.npy`: 2-D arrays of f32 or f64 in C order, format versions 1 to 3.
//!
//! `\x93NUMPY`, major, minor, the header's length (u16, from version 2 on u32, little
//! endian), the header (a Python dictionary as text: `descr`, `fortran_order`, `shape`),
//! then the values.

use std::path::Path;

use super::DatasetError;

/// More bytes than any capture's poses.
const MAX_BYTES: u64 = 64 << 20;

/// Completes "expected …".
pub(super) const EXPECTED: &str = "a .npy array of f64, a row of 17 numbers an image (LLFF)";

/// A matrix.
#[derive(Debug, PartialEq)]
pub(super) struct Matrix {
    pub(super) columns: usize,
    /// Row after row.
    pub(super) values: Vec<f64>,
}

/// Reads a file.
pub(super) fn read(file: &Path) -> Result<Matrix, DatasetError> {
    let refuse = |problem: String| DatasetError::Contents {
        file: file.to_owned(),
        problem,
        expected: EXPECTED,
    };
    let length = std::fs::metadata(file).map_err(|error| refuse(error.to_string()))?.len();
    if length > MAX_BYTES {
        return Err(refuse(format!("{length} bytes, at most {MAX_BYTES} are read")));
    }
    let bytes = std::fs::read(file).map_err(|error| refuse(error.to_string()))?;
    parse(&bytes).map_err(refuse)
}

fn parse(bytes: &[u8]) -> Result<Matrix, String> {
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("it does not begin with \\x93NUMPY")?;
    let cut_off = || format!("the file is cut off after {} bytes", bytes.len());
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut_off)?;
    let (length, rest) = match version[0] {
        1 => {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut_off)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut_off)?;
            (u32::from_le_bytes(*length) as usize, rest)
        }
        other => return Err(format!("format version {other}")),
    };
    let (header, values) = rest.split_at_checked(length).ok_or_else(cut_off)?;
    let header = String::from_utf8_lossy(header);
    if value_of(&header, "fortran_order")?.starts_with("True") {
        return Err("values in Fortran order".to_owned());
    }
    let descr = value_of(&header, "descr")?;
    let descr = descr.trim_start_matches(['\'', '"']);
    let width = match descr.get(..3) {
        Some("<f8") => 8,
        Some("<f4") => 4,
        _ => {
            let end = descr.find(['\'', '"']).unwrap_or(descr.len());
            return Err(format!("values of type {}", &descr[..end]));
        }
    };
    let shape = value_of(&header, "shape")?;
    let [rows, columns] = dimensions(shape).ok_or_else(|| {
        let end = shape.find(')').map_or(shape.len(), |end| end + 1);
        format!("shape {}", &shape[..end])
    })?;
    let expected = rows.checked_mul(columns).and_then(|n| n.checked_mul(width));
    if expected != Some(values.len()) {
        return Err(format!(
            "{} bytes of values for {rows} rows of {columns}; is it cut off?",
            values.len()
        ));
    }
    let values = match width {
        8 => values.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        _ => values.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect(),
    };
    Ok(Matrix { columns, values })
}

/// What follows a key of the header.
fn value_of<'h>(header: &'h str, key: &str) -> Result<&'h str, String> {
    let at = [format!("'{key}'"), format!("\"{key}\"")].iter().find_map(|quoted| {
        let rest = &header[header.find(quoted.as_str())? + quoted.len()..];
        rest.trim_start().strip_prefix(':')
    });
    at.map(str::trim_start).ok_or_else(|| format!("no {key} in the header"))
}

/// `(20, 17)` and nothing else.
fn dimensions(shape: &str) -> Option<[usize; 2]> {
    let inside = shape.strip_prefix('(')?.split_once(')')?.0;
    let sides: Option<Vec<usize>> =
        inside.trim_end_matches(',').split(',').map(|side| side.trim().parse().ok()).collect();
    <[usize; 2]>::try_from(&sides?[..]).ok()
}
