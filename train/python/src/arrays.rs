//! NumPy arrays in and out.

use numpy::{
    Element, IntoPyArray, PyArray, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyReadwriteArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pocketnerf_train::picture::image_file;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// An array of numbers for Python.
pub(crate) type Floats<'py> = Bound<'py, PyArrayDyn<f32>>;

/// A shape as Python writes it.
pub(crate) fn tuple(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        shape => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// Vectors of three, in an array of shape (..., 3).
pub(crate) struct Vectors<'py> {
    array: PyReadonlyArrayDyn<'py, f32>,
    name: &'static str,
}

impl<'py> Vectors<'py> {
    pub(crate) fn new(given: &Bound<'py, PyAny>, name: &'static str) -> PyResult<Self> {
        let array = numbers(given, name)?;
        match array.shape().last() {
            Some(3) => Ok(Self { array, name }),
            _ => Err(PyValueError::new_err(format!(
                "{name}: shape {}, expected (..., 3): x, y and z last",
                tuple(array.shape())
            ))),
        }
    }

    pub(crate) fn get(&self) -> PyResult<&[[f32; 3]]> {
        Ok(self.array.as_slice()?.as_chunks().0)
    }

    /// The shape without the last axis.
    pub(crate) fn shape(&self) -> &[usize] {
        &self.array.shape()[..self.array.ndim() - 1]
    }

    /// Refuses others that are not as many.
    pub(crate) fn expect_same(&self, other: &Self) -> PyResult<()> {
        if self.shape() == other.shape() {
            return Ok(());
        }
        Err(PyValueError::new_err(format!(
            "{} {} and {} {}: expected arrays of one shape",
            self.name,
            tuple(self.array.shape()),
            other.name,
            tuple(other.array.shape())
        )))
    }
}

/// Numbers as a contiguous array of `f32` of their own shape.
pub(crate) fn numbers<'py>(
    given: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, f32>> {
    let py = given.py();
    let arguments = PyDict::new(py);
    arguments.set_item("dtype", "float32")?;
    arguments.set_item("order", "C")?;
    let asarray = py.import("numpy")?.getattr("asarray")?;
    let wrong = |error: &dyn std::fmt::Display| {
        PyTypeError::new_err(format!("{name}: expected an array of numbers: {error}"))
    };
    let array = asarray.call((given,), Some(&arguments)).map_err(|error| wrong(&error))?;
    array.extract().map_err(|error: PyErr| wrong(&error))
}

/// As many numbers as `N`, from a sequence or an array.
pub(crate) fn fixed<const N: usize>(given: &Bound<'_, PyAny>, name: &str) -> PyResult<[f32; N]> {
    let array = numbers(given, name)?;
    let found = array.as_slice()?.try_into().ok().filter(|_| array.ndim() == 1);
    found.ok_or_else(|| {
        let found = tuple(array.shape());
        PyValueError::new_err(format!("{name}: shape {found}, expected ({N},)"))
    })
}

/// An array of this shape and these values, which it owns from now on.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    values.into_pyarray(py).reshape(shape.to_vec())
}

/// The caller's array to write to, or a new one of zeros.
pub(crate) fn output<'py, T: Element>(
    py: Python<'py>,
    given: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
    (name, dtype): (&str, &str),
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    let Some(given) = given else {
        return Ok(PyArray::zeros(py, shape.to_vec(), false).try_readwrite()?);
    };
    let found = given.cast::<PyUntypedArray>().map_err(|_| {
        let shape = tuple(shape);
        PyTypeError::new_err(format!("{name}: expected a NumPy array of {dtype}, shape {shape}"))
    })?;
    let wrong = |what: String| {
        let shape = tuple(shape);
        PyValueError::new_err(format!(
            "{name}: {what}, expected a writable C-contiguous array of {dtype}, shape {shape}"
        ))
    };
    let Ok(array) = given.cast::<PyArrayDyn<T>>() else {
        return Err(wrong(format!("dtype {}", found.dtype())));
    };
    if array.shape() != shape {
        return Err(wrong(format!("shape {}", tuple(array.shape()))));
    }
    if !array.is_c_contiguous() {
        return Err(wrong(format!("strides {:?}", array.strides())));
    }
    array.try_readwrite().map_err(|error| wrong(error.to_string()))
}

/// A picture, an array of `uint8` of shape (height, width, 3) or (height, width, 4) with straight
/// alpha, as the bytes of a PNG file.
#[pyfunction]
pub(crate) fn encode_png<'py>(
    py: Python<'py>,
    pixels: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyBytes>> {
    let wrong = || {
        PyValueError::new_err(
            "pixels: expected a C-contiguous array of uint8, shape (height, width, 3 or 4)",
        )
    };
    let array: PyReadonlyArrayDyn<'_, u8> = pixels.extract().map_err(|_| wrong())?;
    let &[height, width, channels] = array.shape() else { return Err(wrong()) };
    let values = array.as_slice().map_err(|_| wrong())?;
    let size = [width, height].map(u32::try_from);
    let ([Ok(width), Ok(height)], 3 | 4, false) = (size, channels, values.is_empty()) else {
        return Err(wrong());
    };
    let bytes = py.detach(|| match channels {
        3 => image_file::encode_rgb(width, height, values),
        _ => image_file::encode_rgba(width, height, values),
    });
    Ok(PyBytes::new(py, &bytes.map_err(|error| PyValueError::new_err(error.to_string()))?))
}
