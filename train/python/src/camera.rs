//! Cameras, in the dataset's coordinates and units.

use pocketnerf_core::Camera as CoreCamera;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{Floats, array, fixed, numbers, tuple};
use crate::errors::refused;
use crate::pickling::made_again;

/// A pinhole camera in the dataset's coordinates and units.
///
/// :param width: pixels along x, 1 to 16384.
/// :param height: pixels along y, 1 to 16384.
/// :param camera_to_world: a matrix of shape (4, 4) or (3, 4), whose columns are right, up, back
///     (OpenGL, Blender, nerfstudio) and the position; with ``convention="opencv"`` right, down,
///     forward (OpenCV; COLMAP's inverse) and the position.
/// :param fov_x: horizontal field of view, radians.
/// :param focal: focal length in pixels instead, one number or (x, y).
/// :param center: principal point (x, y), pixels from the top left corner; the middle by default.
///     The centre of pixel (i, j) is at (i + 0.5, j + 0.5).
///
/// >>> camera = Camera(4, 2, numpy.eye(4), fov_x=1.0)
/// >>> camera.center
/// (2.0, 1.0)
#[pyclass(frozen, eq, module = "pocketnerf")]
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Camera(pub(crate) CoreCamera);

/// Field of view where none is given, radians.
const FOV_X: f32 = 0.7;

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (width, height, camera_to_world, *, fov_x=None, focal=None, center=None, convention="opengl"))]
    fn new(
        width: u32,
        height: u32,
        camera_to_world: &Bound<'_, PyAny>,
        fov_x: Option<f32>,
        focal: Option<&Bound<'_, PyAny>>,
        center: Option<&Bound<'_, PyAny>>,
        convention: &str,
    ) -> PyResult<Self> {
        let mut pose = pose(camera_to_world)?;
        match convention {
            "opengl" => {}
            "opencv" => {
                for row in 0..3 {
                    pose[4 * row + 1] = -pose[4 * row + 1];
                    pose[4 * row + 2] = -pose[4 * row + 2];
                }
            }
            other => {
                return Err(PyValueError::new_err(format!(
                    "convention: {other:?}, expected \"opengl\" or \"opencv\""
                )));
            }
        }
        let mut camera = CoreCamera::from_fov_x(width, height, fov_x.unwrap_or(FOV_X), pose);
        match (fov_x, focal) {
            (Some(_), Some(_)) => {
                return Err(PyTypeError::new_err("fov_x and focal: expected one of them"));
            }
            (None, None) => {
                return Err(PyTypeError::new_err(
                    "expected fov_x, the horizontal field of view in radians, or focal, in pixels",
                ));
            }
            (Some(angle), None) if !(angle > 0.0 && angle < std::f32::consts::PI) => {
                return Err(PyValueError::new_err(format!(
                    "fov_x: {angle}, expected radians from 0 to pi"
                )));
            }
            (Some(_), None) => {}
            (None, Some(focal)) => {
                camera.focal = match focal.extract::<f32>() {
                    Ok(both) => [both; 2],
                    Err(_) => fixed(focal, "focal")?,
                };
            }
        }
        if let Some(center) = center {
            camera.center = fixed(center, "center")?;
        }
        Self::checked(camera)
    }

    /// The camera at ``eye`` that looks at ``target``, with ``up`` upwards ((0, 0, 1) by default);
    /// ``fov_x`` in radians.
    ///
    /// >>> Camera.look_at((3, 0, 1), (0, 0, 0), width=4, height=3).position.tolist()
    /// [3.0, 0.0, 1.0]
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, width, height, fov_x=FOV_X, up=None))]
    fn look_at(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        width: u32,
        height: u32,
        fov_x: f32,
        up: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let up = up.map_or(Ok([0.0, 0.0, 1.0]), |up| fixed(up, "up"))?;
        let pose = CoreCamera::look_at(fixed(eye, "eye")?, fixed(target, "target")?, up);
        Self::checked(CoreCamera::from_fov_x(width, height, fov_x, pose))
    }

    /// Pixels along x.
    #[getter]
    fn width(&self) -> u32 {
        self.0.width
    }

    /// Pixels along y.
    #[getter]
    fn height(&self) -> u32 {
        self.0.height
    }

    /// Horizontal field of view, radians.
    #[getter]
    fn fov_x(&self) -> f32 {
        2.0 * (0.5 * self.0.width as f32 / self.0.focal[0]).atan()
    }

    /// Focal lengths along x and y, pixels.
    #[getter]
    fn focal(&self) -> (f32, f32) {
        self.0.focal.into()
    }

    /// Principal point, pixels from the top left corner.
    #[getter]
    fn center(&self) -> (f32, f32) {
        self.0.center.into()
    }

    /// A new array of shape (4, 4): columns right, up, back and the position.
    #[getter]
    fn camera_to_world<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.camera_to_world.to_vec(), &[4, 4])
    }

    /// Where the camera is, an array of shape (3,), dataset units.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.position().to_vec(), &[3])
    }

    /// The same camera with a picture of another size and as wide a view.
    fn resized(&self, width: u32, height: u32) -> PyResult<Self> {
        Self::checked(resized(&self.0, width, height))
    }

    /// Origins and unit directions of the rays through the centres of all pixels: two arrays of
    /// shape (height, width, 3), dataset units.
    ///
    /// >>> origins, directions = Camera(4, 2, numpy.eye(4), fov_x=1.0).rays()
    /// >>> directions.shape
    /// (2, 4, 3)
    fn rays<'py>(&self, py: Python<'py>) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let shape = [self.0.height as usize, self.0.width as usize, 3];
        let rays: Vec<_> = py.detach(|| rays(&self.0).collect());
        let [origins, directions] = [
            rays.iter().flat_map(|ray| ray.origin).collect(),
            rays.iter().flat_map(|ray| ray.direction).collect(),
        ];
        Ok((array(py, origins, &shape)?, array(py, directions, &shape)?))
    }

    fn __repr__(&self) -> String {
        let CoreCamera { width, height, .. } = self.0;
        let [x, y, z] = self.0.position();
        format!(
            "Camera({width}x{height}, fov_x={:.4}, position=[{x:.4}, {y:.4}, {z:.4}])",
            self.fov_x()
        )
    }

    /// Pickled as what the camera is made of.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let (kind, this) = (py.get_type::<Self>(), slf.get());
        let arguments = PyDict::new(py);
        arguments.set_item("width", this.0.width)?;
        arguments.set_item("height", this.0.height)?;
        arguments.set_item("camera_to_world", this.camera_to_world(py)?)?;
        arguments.set_item("focal", this.focal())?;
        arguments.set_item("center", this.center())?;
        made_again(&kind, &arguments)
    }
}

impl Camera {
    fn checked(camera: CoreCamera) -> PyResult<Self> {
        camera.validate().map_err(refused)?;
        Ok(Self(camera))
    }
}

/// The same camera with a picture of another size: as wide a view.
pub(crate) fn resized(camera: &CoreCamera, width: u32, height: u32) -> CoreCamera {
    let scale = width as f32 / camera.width.max(1) as f32;
    let center = [
        camera.center[0] * scale,
        camera.center[1] * scale + 0.5 * (height as f32 - camera.height as f32 * scale),
    ];
    CoreCamera { width, height, focal: camera.focal.map(|f| f * scale), center, ..*camera }
}

/// The rays through the centres of all pixels, row after row.
fn rays(camera: &CoreCamera) -> impl Iterator<Item = pocketnerf_core::Ray> + '_ {
    let (width, height) = (camera.width, camera.height);
    let row = move |y: u32| (0..width).map(move |x| camera.ray(x as f32 + 0.5, y as f32 + 0.5));
    (0..height).flat_map(row)
}

/// A 4x4 or 3x4 matrix.
fn pose(given: &Bound<'_, PyAny>) -> PyResult<[f32; 16]> {
    let array = numbers(given, "camera_to_world")?;
    let values = array.as_slice()?;
    let shape = numpy::PyUntypedArrayMethods::shape(&*array);
    let mut pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    match shape {
        [3 | 4, 4] => pose[..values.len()].copy_from_slice(values),
        _ => {
            return Err(PyValueError::new_err(format!(
                "camera_to_world: shape {}, expected (4, 4) or (3, 4)",
                tuple(shape)
            )));
        }
    }
    if pose[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(PyValueError::new_err("camera_to_world: last row, expected 0, 0, 0, 1"));
    }
    Ok(pose)
}
