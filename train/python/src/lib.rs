//! The compiled part of the Python package `pocketnerf`: models, cameras and datasets as Python
//! objects, and the program's commands in Python's process.
//!
//! What users see is documented in Python, in `package/pocketnerf`.

mod arrays;
mod camera;
mod command;
mod dataset;
mod errors;
mod files;
mod model;
mod photographs;
mod pickling;
mod threads;

use pyo3::prelude::*;

/// Radiance fields, trained and rendered on CPUs.
#[pymodule(gil_used = true)]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    errors::add_to(module)?;
    module.add_class::<camera::Camera>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<dataset::Dataset>()?;
    module.add_function(wrap_pyfunction!(command::run, module)?)?;
    module.add_function(wrap_pyfunction!(command::main, module)?)?;
    module.add_function(wrap_pyfunction!(command::options, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::encode_png, module)?)?;
    module.add_function(wrap_pyfunction!(files::write_file, module)?)?;
    module.add_function(wrap_pyfunction!(threads::num_threads, module)?)?;
    module.add_function(wrap_pyfunction!(threads::set_num_threads, module)?)?;
    Ok(())
}
