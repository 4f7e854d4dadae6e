//! Files, through the one durable writer.

use std::path::{Path, PathBuf};

use pocketnerf_train::output::write_atomic;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

/// Writes a file that is there as a whole or not at all, while other threads of Python go on.
pub(crate) fn write(py: Python<'_>, path: &Path, data: &[u8]) -> PyResult<()> {
    let written = py.detach(|| write_atomic(path, data));
    written.map_err(|error| PyOSError::new_err(error.to_string()))
}

/// Writes a file that is there as a whole or not at all.
#[pyfunction]
pub(crate) fn write_file(py: Python<'_>, path: PathBuf, data: &[u8]) -> PyResult<()> {
    write(py, &path, data)
}
