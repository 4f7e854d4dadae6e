//! Errors as Python exceptions, each with one line of text.

use std::io;
use std::path::Path;

use pyo3::create_exception;
use pyo3::exceptions::{
    PyException, PyFileNotFoundError, PyKeyboardInterrupt, PyOSError, PyPermissionError,
    PyValueError,
};
use pyo3::prelude::*;

create_exception!(pocketnerf, Error, PyException);
create_exception!(pocketnerf, DatasetError, Error);
create_exception!(pocketnerf, ModelError, Error);
create_exception!(pocketnerf, Interrupted, PyKeyboardInterrupt);

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    let interrupted = py.get_type::<Interrupted>();
    interrupted.setattr("checkpoint", py.None())?;
    let error = py.get_type::<Error>();
    error.setattr("checkpoint", py.None())?;
    let docs = [
        (&error, "What failed, in one line: what was found, what was expected, what to do."),
        (&py.get_type::<DatasetError>(), "A dataset cannot be read."),
        (&py.get_type::<ModelError>(), "A model file cannot be opened."),
        (
            &interrupted,
            "Ctrl-C stopped long work. `checkpoint` is where training is saved, or None.",
        ),
    ];
    for (kind, doc) in docs {
        kind.setattr("__doc__", doc)?;
        module.add(kind.name()?.to_string(), kind)?;
    }
    Ok(())
}

/// With where a run of training is saved.
pub(crate) fn with_checkpoint(py: Python<'_>, error: PyErr, checkpoint: Option<&Path>) -> PyErr {
    if let Some(checkpoint) = checkpoint {
        // An exception that takes no attributes is told all the same.
        let _ = error.value(py).setattr("checkpoint", checkpoint.display().to_string());
    }
    error
}

/// What a model does not answer, or a number without meaning.
pub(crate) fn refused(error: pocketnerf_core::Error) -> PyErr {
    match error {
        pocketnerf_core::Error::Unsupported(_) => ModelError::new_err(error.to_string()),
        error => PyValueError::new_err(error.to_string()),
    }
}

/// A file that cannot be read or written.
pub(crate) fn of_file(path: &Path, what: &str, error: &io::Error) -> PyErr {
    let line = format!("{}: cannot be {what}: {error}", path.display());
    match error.kind() {
        io::ErrorKind::NotFound => PyFileNotFoundError::new_err(line),
        io::ErrorKind::PermissionDenied => PyPermissionError::new_err(line),
        _ => PyOSError::new_err(line),
    }
}
