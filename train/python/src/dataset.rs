//! Photographs with cameras, in memory.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArrayDyn;
use pocketnerf_core::Camera as CoreCamera;
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{self as train, DatasetError as Refused, LoadOptions, Split, View};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::array;
use crate::camera::Camera;
use crate::errors::DatasetError;
use crate::photographs::{corners, mask, view};
use crate::pickling::made_again;
use crate::threads::without_python;

/// Photographs with cameras, in memory: for `train` and `evaluate` in place of a folder.
///
/// :param images: arrays of ``uint8``, each of shape (height, width, 3), or (height, width, 4)
///     with straight alpha, in sRGB.
/// :param cameras: a :class:`Camera` each, of the image's size.
/// :param name: what models say of their origin.
/// :param names: a name each, for messages and scores.
/// :param masks: arrays of ``bool`` of shape (height, width): which pixels count.
/// :param aabb: the box of the scene, array of shape (2, 3): smallest and largest corner.
/// :param val: numbers of the images that are held out for ``val``.
/// :param test: numbers of the images that are held out for ``test``.
///
/// >>> images = numpy.full((3, 16, 16, 3), 255, numpy.uint8)
/// >>> eyes = [(3, 0, 1), (0, 3, 1), (-3, 0, 1)]
/// >>> cameras = [Camera.look_at(eye, (0, 0, 0), width=16, height=16) for eye in eyes]
/// >>> Dataset(images, cameras, test=[2])
/// Dataset("memory": 2 train, 1 test views)
#[pyclass(frozen, module = "pocketnerf")]
pub(crate) struct Dataset {
    splits: Arc<Vec<train::Dataset>>,
    /// What [`load`](Self::load) was given.
    origin: Option<(PathBuf, u32, u32)>,
}

impl Dataset {
    pub(crate) fn splits(&self) -> Arc<Vec<train::Dataset>> {
        Arc::clone(&self.splits)
    }

    fn split(&self, name: &str) -> PyResult<&train::Dataset> {
        let split: Split = name.parse().map_err(PyValueError::new_err)?;
        self.splits.iter().find(|dataset| dataset.split == split).ok_or_else(|| {
            let has: Vec<&str> = self.splits.iter().map(|dataset| dataset.split.name()).collect();
            PyValueError::new_err(format!(
                "{name}: this dataset has no such split; it has {}",
                has.join(", ")
            ))
        })
    }
}

#[pymethods]
impl Dataset {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    #[pyo3(signature = (images, cameras, *, name="memory", names=None, masks=None, aabb=None, val=None, test=None))]
    fn new(
        py: Python<'_>,
        images: &Bound<'_, PyAny>,
        cameras: Vec<Bound<'_, Camera>>,
        name: &str,
        names: Option<Vec<String>>,
        masks: Option<&Bound<'_, PyAny>>,
        aabb: Option<&Bound<'_, PyAny>>,
        val: Option<Vec<usize>>,
        test: Option<Vec<usize>>,
    ) -> PyResult<Self> {
        let n = images.len()?;
        let counts = [
            ("cameras", Some(cameras.len())),
            ("names", names.as_ref().map(Vec::len)),
            ("masks", masks.map(PyAnyMethods::len).transpose()?),
        ];
        for (what, found) in counts {
            if let Some(found) = found.filter(|found| *found != n) {
                return Err(PyValueError::new_err(format!(
                    "{found} {what}, expected one for each of {n} images"
                )));
            }
        }
        let aabb = aabb.map(corners).transpose()?;
        let mut views: [Vec<View>; 3] = Default::default();
        for (i, camera) in cameras.iter().enumerate() {
            let view_name = match &names {
                Some(names) => names[i].clone(),
                None => format!("{i:03}"),
            };
            let mut view = view(&images.get_item(i)?, &view_name, camera.get().0)?;
            if let Some(masks) = masks {
                view.mask = Some(mask(&masks.get_item(i)?, &view_name, &view.camera)?);
            }
            let is_in =
                |list: &Option<Vec<usize>>| list.as_ref().is_some_and(|list| list.contains(&i));
            if is_in(&val) {
                views[1].push(view.clone());
            }
            if is_in(&test) {
                views[2].push(view);
            } else if !is_in(&val) {
                views[0].push(view);
            }
        }
        let beyond = [&val, &test].into_iter().flatten().flatten().find(|i| **i >= n);
        if let Some(i) = beyond {
            return Err(PyValueError::new_err(format!(
                "view {i}, expected 0 to {}",
                n.saturating_sub(1)
            )));
        }
        if views[0].is_empty() {
            return Err(PyValueError::new_err("no images to train on, expected at least one"));
        }
        let kinds = Split::ALL.into_iter().zip(views).filter(|(_, views)| !views.is_empty());
        let kinds: Vec<_> = kinds.collect();
        let splits = without_python(py, || {
            let dataset = |(split, views)| train::Dataset {
                aabb,
                ..train::Dataset::new(name, "memory", split, views)
            };
            kinds.into_iter().map(dataset).collect()
        })?;
        Ok(Self { splits: Arc::new(splits), origin: None })
    }

    /// Reads a folder, or ``"builtin"`` or ``"builtin:NAME"``, as `train` does: all splits that it
    /// has.
    ///
    /// :param downscale_factor: makes images so many times smaller along each side.
    /// :param hold_every: every so many images are held out where the dataset has no splits.
    ///
    /// >>> Dataset.load("photographs")
    /// Dataset("photographs": 48 train, 3 test views)
    #[staticmethod]
    #[pyo3(signature = (path, *, downscale_factor=1, hold_every=8))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        downscale_factor: u32,
        hold_every: u32,
    ) -> PyResult<Self> {
        let options = LoadOptions { downscale_factor, hold_every, ..LoadOptions::default() };
        let read = |split| match built_in(&path) {
            Some(scene) => Ok(scene.dataset(split, downscale_factor)),
            None => train::load_with(&path, split, &options),
        };
        let splits = without_python(py, || {
            let mut splits = vec![read(Split::Train)?];
            // Many datasets have no others.
            splits
                .extend([Split::Val, Split::Test].into_iter().filter_map(|split| read(split).ok()));
            Ok::<_, Refused>(splits)
        })?;
        let splits = splits.map_err(|error| DatasetError::new_err(error.to_string()))?;
        let origin = Some((path, downscale_factor, hold_every));
        Ok(Self { splits: Arc::new(splits), origin })
    }

    /// The dataset's name.
    #[getter]
    fn name(&self) -> String {
        self.splits[0].name()
    }

    /// Names of the splits that there are: train, val, test.
    #[getter(splits)]
    fn split_names(&self) -> Vec<&'static str> {
        self.splits.iter().map(|dataset| dataset.split.name()).collect()
    }

    /// The images of a split: arrays of ``uint8`` of shape (height, width, 4), straight alpha.
    #[pyo3(signature = (split="train"))]
    fn images<'py>(
        &self,
        py: Python<'py>,
        split: &str,
    ) -> PyResult<Vec<Bound<'py, PyArrayDyn<u8>>>> {
        let image = |view: &View| {
            let CoreCamera { width, height, .. } = view.camera;
            array(py, view.rgba.clone(), &[height as usize, width as usize, 4])
        };
        self.split(split)?.views.iter().map(image).collect()
    }

    /// The cameras of a split.
    #[pyo3(signature = (split="train"))]
    fn cameras(&self, split: &str) -> PyResult<Vec<Camera>> {
        let split = self.split(split)?;
        let cameras = split.views.iter().map(|view| Camera(split.camera_in_files(&view.camera)));
        Ok(cameras.collect())
    }

    /// The names of a split's images.
    #[pyo3(signature = (split="train"))]
    fn names(&self, split: &str) -> PyResult<Vec<String>> {
        Ok(self.split(split)?.views.iter().map(|view| view.name.clone()).collect())
    }

    fn __len__(&self) -> usize {
        self.splits.iter().map(|dataset| dataset.views.len()).sum()
    }

    fn __repr__(&self) -> String {
        let count = |dataset: &train::Dataset| format!("{} {}", dataset.views.len(), dataset.split);
        let counts: Vec<String> = self.splits.iter().map(count).collect();
        format!("Dataset({:?}: {} views)", self.name(), counts.join(", "))
    }

    /// Pickled as the folder that it was read from, or as what it was made of.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let kind = py.get_type::<Self>();
        let arguments = PyDict::new(py);
        if let Some((path, downscale_factor, hold_every)) = &this.origin {
            arguments.set_item("path", path)?;
            arguments.set_item("downscale_factor", downscale_factor)?;
            arguments.set_item("hold_every", hold_every)?;
            return made_again(&kind.getattr("load")?, &arguments);
        }
        let views: Vec<(&View, Split)> = this
            .splits
            .iter()
            .flat_map(|dataset| dataset.views.iter().map(|view| (view, dataset.split)))
            .collect();
        let shape = |view: &View| [view.camera.height as usize, view.camera.width as usize];
        let images = views.iter().map(|(view, _)| {
            let [height, width] = shape(view);
            array(py, view.rgba.clone(), &[height, width, 4])
        });
        arguments.set_item("images", images.collect::<PyResult<Vec<_>>>()?)?;
        let cameras: Vec<_> = views.iter().map(|(view, _)| Camera(view.camera)).collect();
        arguments.set_item("cameras", cameras)?;
        let names: Vec<_> = views.iter().map(|(view, _)| &view.name).collect();
        arguments.set_item("names", names)?;
        arguments.set_item("name", this.name())?;
        if views.iter().any(|(view, _)| view.mask.is_some()) {
            let masks = views.iter().map(|(view, _)| {
                let all = || vec![255; view.rgba.len() / 4];
                let mask = view.mask.clone().unwrap_or_else(all);
                array(py, mask.into_iter().map(|counts| counts != 0).collect(), &shape(view))
            });
            arguments.set_item("masks", masks.collect::<PyResult<Vec<_>>>()?)?;
        }
        arguments.set_item("aabb", this.splits[0].aabb)?;
        for split in [Split::Val, Split::Test] {
            let numbers = views.iter().enumerate().filter(|(_, (_, of))| *of == split);
            let numbers: Vec<usize> = numbers.map(|(i, _)| i).collect();
            arguments.set_item(split.name(), (!numbers.is_empty()).then_some(numbers))?;
        }
        made_again(&kind, &arguments)
    }
}

/// The built-in scene of this name, unless it names a folder.
fn built_in(path: &std::path::Path) -> Option<Scene> {
    let name = path.to_str().filter(|_| !path.exists())?.strip_prefix("builtin")?;
    if name.is_empty() { Some(Scene::StillLife) } else { Scene::named(name.strip_prefix(':')?) }
}
