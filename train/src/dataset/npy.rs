//! `.npy` files of captures: a matrix of numbers.

use std::path::Path;

use pocketnerf_formats::import::{ImportError, Tensor};

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
    let wrong = |error: ImportError| refuse(error.to_string());
    let tensor = Tensor::from_npy(&bytes).map_err(wrong)?;
    let &[_, columns] = tensor.shape() else {
        return Err(refuse(format!("{} dimensions where 2 were expected", tensor.shape().len())));
    };
    Ok(Matrix { columns, values: tensor.to_f64().map_err(wrong)? })
}
