//! Objects that are pickled as the call that makes them again.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// What `__reduce__` returns for an object that `call` makes of these keywords.
pub(crate) fn made_again<'py>(
    call: &Bound<'py, PyAny>,
    keywords: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyTuple>> {
    let py = call.py();
    // Calls of `__reduce__` have no keywords of their own.
    let partial = py.import("functools")?.call_method("partial", (call,), Some(keywords))?;
    (partial, ()).into_pyobject(py)
}
