//! An open model.

mod opened;
mod pictures;
mod query;
mod questions;
mod render;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use pocketnerf_core::Camera as CoreCamera;
use pocketnerf_core::camera::Orbit;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use crate::arrays::{Floats, array};
use crate::camera::{Camera, resized};
use crate::errors::of_file;
use crate::threads::without_python;
use opened::Opened;

/// Side of pictures where neither the caller nor the file says.
const SIDE: u32 = 400;

/// An open model. It never changes, so that threads may share it; processes get it by pickling.
///
/// Cameras, points and lengths are in the coordinates and units of the dataset that it was
/// trained on.
#[pyclass(frozen, module = "pocketnerf", weakref)]
pub(crate) struct Model(Mutex<Option<Arc<Opened>>>);

impl Model {
    fn new(bytes: Vec<u8>, name: Option<&std::path::Path>) -> PyResult<Self> {
        Ok(Self(Mutex::new(Some(Arc::new(Opened::new(bytes, name)?)))))
    }

    fn get(&self) -> PyResult<Arc<Opened>> {
        let opened = self.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        opened.ok_or_else(|| PyValueError::new_err("the model is closed"))
    }
}

#[pymethods]
impl Model {
    /// Opens a model file: a path, or its bytes (``bytes``, ``bytearray``, ``memoryview``, an array).
    /// All of it is checked; packed files are unpacked.
    ///
    /// >>> Model.open("model.pnerf").method
    /// 'hash-grid'
    #[staticmethod]
    fn open(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(bytes) = source.cast::<PyBytes>() {
            let bytes = bytes.as_bytes().to_vec();
            return without_python(py, || Self::new(bytes, None))?;
        }
        if let Ok(path) = source.extract::<PathBuf>() {
            return without_python(py, || {
                let bytes = std::fs::read(&path).map_err(|e| of_file(&path, "read", &e))?;
                Self::new(bytes, Some(&path))
            })?;
        }
        // What exposes its bytes: bytearray, memoryview, an array.
        let view = py.import("builtins")?.call_method1("memoryview", (source,)).map_err(|_| {
            let found = source.get_type();
            PyTypeError::new_err(format!("{found}: expected a path or the bytes of a model file"))
        })?;
        let bytes: Vec<u8> = view.call_method0("tobytes")?.extract()?;
        without_python(py, || Self::new(bytes, None))?
    }

    /// Writes the model as a file. An older one is replaced by a whole one.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        crate::files::write(py, &path, self.get()?.stored())
    }

    /// The bytes of the model's file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, self.get()?.stored()))
    }

    /// Frees the memory. What is under way in other threads ends first.
    fn close(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Whether the model is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.get().is_err()
    }

    fn __enter__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        slf.get().get()?;
        Ok(slf)
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, _error: &Bound<'_, PyTuple>) {
        self.close();
    }

    /// The kind of field: ``hash-grid`` or ``nerf``.
    #[getter]
    fn method(&self) -> PyResult<&'static str> {
        Ok(self.get()?.file().model.field.kind())
    }

    /// Bytes of the model's file.
    #[getter]
    fn nbytes(&self) -> PyResult<usize> {
        Ok(self.get()?.stored().len())
    }

    /// The box around the scene, an array of shape (2, 3), dataset units: smallest and largest
    /// corner; ``None`` for scenes without an end.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        let bounds = self.get()?.bounds();
        bounds.map(|bounds| array(py, bounds.as_flattened().to_vec(), &[2, 3])).transpose()
    }

    /// The colour behind pictures, sRGB from 0 to 1.
    #[getter]
    fn background(&self) -> PyResult<(f32, f32, f32)> {
        Ok(self.get()?.file().model.display.srgb_background().into())
    }

    /// The camera that shows the model first: that of a photograph, where the file says.
    #[getter]
    fn camera(&self) -> PyResult<Camera> {
        Ok(Camera(self.get()?.camera()))
    }

    /// Cameras of photographs that the model was trained on, or an even choice of them.
    #[getter]
    fn photographs(&self) -> PyResult<Vec<Camera>> {
        Ok(self.get()?.photographs().into_iter().map(Camera).collect())
    }

    /// What is up in the dataset's coordinates, a unit vector: +z where the file says nothing.
    ///
    /// >>> model.up
    /// (0.0, 0.0, 1.0)
    #[getter]
    fn up(&self) -> PyResult<(f32, f32, f32)> {
        Ok(self.get()?.file().about.world.up().into())
    }

    /// Metres per unit of the dataset's coordinates, where the file says.
    #[getter]
    fn metres(&self) -> PyResult<Option<f32>> {
        Ok(self.get()?.file().about.world.metres)
    }

    /// A camera on a sphere around the scene, which looks at its middle.
    ///
    /// :param azimuth: angle around what is up (:attr:`up`) from the x axis, or from the y axis if x
    ///     is up, radians.
    /// :param elevation: angle above the horizon, radians.
    /// :param distance: from the middle, dataset units; as far as shows the scene by default.
    ///
    /// >>> model.orbit(0.5, 0.3, width=640, height=480).width
    /// 640
    #[pyo3(signature = (azimuth, elevation=0.5, *, distance=None, width=None, height=None))]
    fn orbit(
        &self,
        azimuth: f32,
        elevation: f32,
        distance: Option<f32>,
        width: Option<u32>,
        height: Option<u32>,
    ) -> PyResult<Camera> {
        let opened = self.get()?;
        let own = sized(&opened.camera(), width, height)?;
        let (target, usual) = opened.center()?;
        let radius = distance.unwrap_or(usual);
        if ![azimuth, elevation, radius].iter().all(|v| v.is_finite()) || radius <= 0.0 {
            return Err(PyValueError::new_err(
                "angles and distance: expected numbers, a distance above 0",
            ));
        }
        let axis = opened.file().about.world.up();
        let pose = Orbit { target, radius, azimuth, elevation, axis, up: axis }.pose();
        Ok(Camera(CoreCamera { camera_to_world: pose, ..own }))
    }

    fn __repr__(&self) -> String {
        match self.get() {
            Ok(opened) => format!(
                "Model({}, {} bytes)",
                opened.file().model.field.kind(),
                opened.stored().len()
            ),
            Err(_) => "Model(closed)".to_owned(),
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let open = py.get_type::<Self>().getattr("open")?;
        (open, (slf.get().to_bytes(py)?,)).into_pyobject(py)
    }
}

impl Model {
    /// The camera of a picture, in the dataset's coordinates.
    fn through(
        &self,
        opened: &Opened,
        camera: Option<&Bound<'_, Camera>>,
        width: Option<u32>,
        height: Option<u32>,
    ) -> PyResult<CoreCamera> {
        let camera = camera.map_or_else(|| opened.camera(), |camera| camera.get().0);
        sized(&camera, width, height)
    }
}

/// The same camera with a picture of this size; one side that is given keeps the shape.
fn sized(camera: &CoreCamera, width: Option<u32>, height: Option<u32>) -> PyResult<CoreCamera> {
    let [w, h] = [camera.width, camera.height].map(f64::from);
    let of = |side: u32, ratio: f64| (f64::from(side) * ratio).round().max(1.0) as u32;
    let (width, height) = match (width, height) {
        (None, None) => return Ok(*camera),
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, of(width, h / w)),
        (None, Some(height)) => (of(height, w / h), height),
    };
    let camera = resized(camera, width, height);
    camera.validate().map_err(crate::errors::refused)?;
    Ok(camera)
}
