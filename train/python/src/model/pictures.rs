//! Pictures of a model, for Python.

use pyo3::prelude::*;

use super::Model;
use super::render::{Depth, Pixels, depth, normals};
use crate::arrays::encode_png;
use crate::camera::Camera;

/// Width of the picture in a notebook.
const NOTEBOOK: u32 = 480;

#[pymethods]
impl Model {
    /// Renders a picture on all threads, while other threads of Python go on.
    ///
    /// :param camera: the model's own by default.
    /// :param width: pixels along x; with one side alone, the camera's shape stays.
    /// :param height: pixels along y.
    /// :param quality: from 0, the fastest, to 1, the finest; as the file says by default.
    /// :param background: ``"white"``, ``"black"`` or three numbers from 0 to 1, sRGB.
    /// :param dtype: ``uint8``, or ``float32`` from 0 to 1; both sRGB.
    /// :param alpha: four channels, the last one straight alpha, and no background.
    /// :param antialias: rays along each side of a pixel, 1 to 8; by default as many as a pixel
    ///     holds pixels of the photographs.
    /// :param out: the array to write to, of the picture's shape and type; nothing is copied.
    /// :param depth_out: an array of ``float32`` of shape (height, width) that takes the depth too,
    ///     of all rays of a pixel together.
    /// :returns: ``out``, or a new array of shape (height, width, 3), or 4 with ``alpha``.
    ///
    /// >>> model.render(width=32, height=24, dtype="float32").shape
    /// (24, 32, 3)
    #[pyo3(signature = (camera=None, *, width=None, height=None, quality=None, background=None,
        dtype=None, alpha=false, antialias=None, out=None, depth_out=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Bound<'py, Camera>>,
        width: Option<u32>,
        height: Option<u32>,
        quality: Option<f32>,
        background: Option<&Bound<'py, PyAny>>,
        dtype: Option<&Bound<'py, PyAny>>,
        alpha: bool,
        antialias: Option<u32>,
        out: Option<Bound<'py, PyAny>>,
        depth_out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let opened = self.get()?;
        let camera = self.through(&opened, camera, width, height)?;
        let pixels = Pixels { quality, alpha, antialias, camera };
        pixels.render(py, &opened, (background, dtype), (out, depth_out))
    }

    /// The expected distance along the ray through each pixel's centre, dataset units: an array of
    /// ``float32`` of shape (height, width), infinite where nothing is. Distances are Euclidean, from
    /// the camera.
    ///
    /// >>> model.depth(width=32, height=24).shape
    /// (24, 32)
    #[pyo3(signature = (camera=None, *, width=None, height=None, quality=None, out=None))]
    fn depth<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Bound<'py, Camera>>,
        width: Option<u32>,
        height: Option<u32>,
        quality: Option<f32>,
        out: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let opened = self.get()?;
        let camera = self.through(&opened, camera, width, height)?;
        depth(py, &opened, &Depth { quality, camera }, out)
    }

    /// Where the surface faces that each pixel's centre sees: unit vectors towards the camera in the
    /// dataset's axes, an array of ``float32`` of shape (height, width, 3); zeros where more than half of
    /// the light passes. Each is that of a plane through what is seen around the pixel.
    ///
    /// >>> model.normals(width=32, height=24).shape
    /// (24, 32, 3)
    #[pyo3(signature = (camera=None, *, width=None, height=None, out=None))]
    fn normals<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Bound<'py, Camera>>,
        width: Option<u32>,
        height: Option<u32>,
        out: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let opened = self.get()?;
        let camera = self.through(&opened, camera, width, height)?;
        normals(py, &opened, &camera, out)
    }

    fn _repr_png_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let own = slf.get().get()?.camera();
        let width = own.width.min(NOTEBOOK);
        let height =
            (u64::from(own.height) * u64::from(width) / u64::from(own.width)).max(1) as u32;
        let pixels = slf.get().render(
            py,
            None,
            Some(width),
            Some(height),
            None,
            None,
            None,
            false,
            None,
            None,
            None,
        )?;
        Ok(encode_png(py, &pixels)?.into_any())
    }
}
