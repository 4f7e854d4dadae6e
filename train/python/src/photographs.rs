//! Photographs and what belongs to them, from NumPy arrays.

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pocketnerf_core::Camera;
use pocketnerf_train::dataset::View;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{numbers, tuple};

/// A photograph of which all counts.
pub(crate) fn view(image: &Bound<'_, PyAny>, name: &str, camera: Camera) -> PyResult<View> {
    let expected = [camera.height as usize, camera.width as usize];
    let wrong = |found: &str| {
        PyValueError::new_err(format!(
            "image {name:?}: {found}, expected uint8 of shape ({}, {}, 3 or 4), as its camera has it",
            expected[0], expected[1]
        ))
    };
    let array: PyReadonlyArrayDyn<'_, u8> = image.extract().map_err(|_| {
        let dtype = image.getattr("dtype").map(|dtype| dtype.to_string());
        PyTypeError::new_err(wrong(&dtype.unwrap_or_else(|_| "no array".to_owned())).to_string())
    })?;
    let (shape, values) = (array.shape(), array.as_array());
    let rgba: Vec<u8> = match shape {
        [height, width, 4] if [*height, *width] == expected => values.iter().copied().collect(),
        [height, width, 3] if [*height, *width] == expected => {
            let mut rgba = Vec::with_capacity(4 * height * width);
            for (i, value) in values.iter().enumerate() {
                rgba.push(*value);
                if i % 3 == 2 {
                    rgba.push(255);
                }
            }
            rgba
        }
        _ => return Err(wrong(&format!("shape {}", tuple(shape)))),
    };
    Ok(View::new(name, camera, rgba))
}

/// Which pixels of a photograph count.
pub(crate) fn mask(mask: &Bound<'_, PyAny>, name: &str, camera: &Camera) -> PyResult<Vec<u8>> {
    let wrong = || {
        PyValueError::new_err(format!(
            "mask {name:?}: expected bool of shape ({}, {})",
            camera.height, camera.width
        ))
    };
    let array: PyReadonlyArrayDyn<'_, bool> = mask.extract().map_err(|_| wrong())?;
    if array.shape() != [camera.height as usize, camera.width as usize] {
        return Err(wrong());
    }
    let mask: Vec<u8> =
        array.as_array().iter().map(|counts| if *counts { 255 } else { 0 }).collect();
    if mask.iter().all(|counts| *counts == 0) {
        return Err(PyValueError::new_err(format!("mask {name:?}: no pixel counts")));
    }
    Ok(mask)
}

/// Smallest and largest corner.
pub(crate) fn corners(given: &Bound<'_, PyAny>) -> PyResult<[[f32; 3]; 2]> {
    let array = numbers(given, "aabb")?;
    let &[a, b, c, d, e, f] = array.as_slice()? else {
        return Err(PyValueError::new_err(format!(
            "aabb: shape {}, expected (2, 3)",
            tuple(array.shape())
        )));
    };
    let (low, high) = ([a, b, c], [d, e, f]);
    if !(0..3).all(|axis| low[axis] < high[axis] && low[axis].is_finite() && high[axis].is_finite())
    {
        return Err(PyValueError::new_err(
            "aabb: expected the smallest corner, then the largest one",
        ));
    }
    Ok([low, high])
}
