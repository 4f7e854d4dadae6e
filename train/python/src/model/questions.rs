//! Questions to a model beside pictures, for Python.

use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use super::{Model, query};
use crate::arrays::{Floats, Vectors, numbers};

#[pymethods]
impl Model {
    /// Sigma at points of shape (..., 3), dataset units: an array of shape (...), 1 / unit; 0 in
    /// empty space.
    ///
    /// >>> model.density([[0, 0, 0], [100, 0, 0]]).shape
    /// (2,)
    fn density<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Floats<'py>> {
        query::density(py, &*self.get()?, &Vectors::new(points, "points")?)
    }

    /// The slope of sigma at points of shape (..., 3): an array of shape (..., 3), 1 / unit².
    /// Surfaces face against it.
    ///
    /// >>> model.density_gradient([0.1, 0.2, 0.3]).shape
    /// (3,)
    fn density_gradient<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        query::density_gradient(py, &*self.get()?, &Vectors::new(points, "points")?)
    }

    /// Colour and sigma at points of shape (..., 3), seen along directions of the same shape: arrays
    /// of shape (..., 3), from 0 to 1 in the model's colour space, and (...), 1 / unit.
    ///
    /// >>> color, sigma = model.radiance([0, 0, 0], [0, 0, -1])
    /// >>> color.shape, sigma.shape
    /// ((3,), ())
    fn radiance<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (points, directions) =
            (Vectors::new(points, "points")?, Vectors::new(directions, "directions")?);
        query::radiance(py, &*self.get()?, &points, &directions)
    }

    /// The part of light, 0 to 1, that passes from ``starts`` to ``ends``, both of shape (..., 3): an
    /// array of shape (...).
    ///
    /// >>> float(model.transmittance([50, 50, 50], [50, 50, 60]))
    /// 1.0
    fn transmittance<'py>(
        &self,
        py: Python<'py>,
        starts: &Bound<'py, PyAny>,
        ends: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let (starts, ends) = (Vectors::new(starts, "starts")?, Vectors::new(ends, "ends")?);
        query::transmittance(py, &*self.get()?, &starts, &ends)
    }

    /// How far rays see, dataset units: an array of shape (...) for origins and directions of shape
    /// (..., 3); infinite where they see nothing.
    ///
    /// :param kind: ``expected``, the mean, as in pictures; ``median``, where half of the light is
    ///     absorbed; ``first_sigma``, the first sample whose sigma exceeds ``threshold``, 1 / unit;
    ///     ``first_opacity``, where the part ``threshold`` of the light is absorbed.
    ///
    /// >>> origins, directions = model.camera.resized(8, 8).rays()
    /// >>> model.ray_depths(origins, directions, kind="median").shape
    /// (8, 8)
    #[pyo3(signature = (origins, directions, *, kind="expected", threshold=None))]
    fn ray_depths<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        kind: &str,
        threshold: Option<f32>,
    ) -> PyResult<Floats<'py>> {
        let rays = (Vectors::new(origins, "origins")?, Vectors::new(directions, "directions")?);
        query::ray_depths(py, &*self.get()?, (&rays.0, &rays.1), (kind, threshold))
    }

    /// Whether there may be something at points of shape (..., 3): an array of ``bool`` of shape (...).
    /// A point that is nowhere counts as occupied.
    ///
    /// >>> bool(model.occupied([100, 100, 100]))
    /// False
    fn occupied<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        query::occupied(py, &*self.get()?, &Vectors::new(points, "points")?)
    }

    /// Whether balls are free: nowhere in them is any density. Centers of shape (..., 3) and radii of
    /// shape (...), or one for all, dataset units. Never true by mistake.
    ///
    /// >>> bool(model.sphere_clear([100, 100, 100], 1.0))
    /// True
    fn sphere_clear<'py>(
        &self,
        py: Python<'py>,
        centers: &Bound<'py, PyAny>,
        radii: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let centers = Vectors::new(centers, "centers")?;
        let broadcast = py.import("numpy")?.call_method1("broadcast_to", (radii, centers.shape()));
        let radii: PyReadonlyArrayDyn<'_, f32> = numbers(&broadcast?, "radii")?;
        query::sphere_clear(py, &*self.get()?, &centers, radii.as_slice()?)
    }

    /// The probability that a body hits something (CATNIPS, Chen et al., arXiv 2302.12931).
    ///
    /// :param points: of shape (..., 3), which fill the body, each standing for ``volume``.
    /// :param volume: of a point, unit³.
    /// :param particle_area: cross section of the smallest thing that matters, unit².
    ///
    /// >>> model.collision_probability([[100, 100, 100]], volume=1e-3, particle_area=1e-2)
    /// 0.0
    #[pyo3(signature = (points, *, volume, particle_area))]
    fn collision_probability(
        &self,
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        volume: f32,
        particle_area: f32,
    ) -> PyResult<f32> {
        let points = Vectors::new(points, "points")?;
        query::collision_probability(py, &*self.get()?, &points, volume, particle_area)
    }
}
