//! Pictures, to memory that NumPy owns.

use std::borrow::Cow;

use numpy::PyReadwriteArrayDyn;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Camera, Display, Error, pixel};
use pocketnerf_train::picture::{self, Antialias, Renderer, Settings};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::opened::Opened;
use crate::arrays::{fixed, output};
use crate::errors::refused;
use crate::threads::without_python;

/// How a picture is rendered.
pub(super) struct Pixels {
    pub(super) quality: Option<f32>,
    pub(super) alpha: bool,
    /// Rays along each side of a pixel; as many as suit the model where it is not said.
    pub(super) antialias: Option<u32>,
    /// In the dataset's coordinates.
    pub(super) camera: Camera,
}

/// The kind of numbers in a picture.
#[derive(Clone, Copy, PartialEq)]
enum DType {
    U8,
    F32,
}

/// An array of the caller, or none.
type Out<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

impl Pixels {
    pub(super) fn render<'py>(
        &self,
        py: Python<'py>,
        opened: &Opened,
        (background, dtype): (Out<'_, 'py>, Out<'_, 'py>),
        (out, depth_out): (Option<Bound<'py, PyAny>>, Out<'_, 'py>),
    ) -> PyResult<Bound<'py, PyAny>> {
        let display = self.display(opened, background)?;
        let most = Tiles::MOST_RAYS;
        if let Some(n) = self.antialias.filter(|n| !(1..=most).contains(n)) {
            let line = format!("antialias: {n} rays along a pixel, expected 1 to {most}");
            return Err(PyValueError::new_err(line));
        }
        let channels = if self.alpha { 4 } else { 3 };
        let shape = [self.camera.height as usize, self.camera.width as usize, channels];
        let mut depth = depth_out
            .map(|given| output::<f32>(py, Some(given), &shape[..2], ("depth_out", "float32")))
            .transpose()?;
        let no_depth: &mut [f32] = &mut [];
        let depth = match &mut depth {
            Some(depth) => depth.as_slice_mut()?,
            None => no_depth,
        };
        let (given, alpha) = (out.as_ref(), self.alpha);
        match kind(dtype, given)? {
            DType::U8 => {
                let mut pixels = output::<u8>(py, given, &shape, ("out", "uint8"))?;
                let to = (pixels.as_slice_mut()?, channels, depth);
                self.run(py, opened, to, |rgba, to| match alpha {
                    true => to.copy_from_slice(&pixel::rgba8(
                        pixel::straight(*rgba),
                        display.color_space,
                    )),
                    false => to.copy_from_slice(&display.rgb8(*rgba)),
                })?;
                Ok(out.unwrap_or_else(|| owned(pixels)))
            }
            DType::F32 => {
                let mut pixels = output::<f32>(py, given, &shape, ("out", "float32"))?;
                let to = (pixels.as_slice_mut()?, channels, depth);
                self.run(py, opened, to, |rgba, to| {
                    let [r, g, b, a] = pixel::straight(*rgba);
                    let color = match alpha {
                        true => [r, g, b],
                        false => pixel::over(*rgba, display.background),
                    };
                    to[..3].copy_from_slice(&display.color_space.to_srgb(color));
                    if let Some(last) = to.get_mut(3) {
                        *last = a;
                    }
                })?;
                Ok(out.unwrap_or_else(|| owned(pixels)))
            }
        }
    }

    /// The model's display with the caller's background.
    fn display(&self, opened: &Opened, background: Out<'_, '_>) -> PyResult<Display> {
        let display = opened.file().model.display;
        let Some(given) = background else { return Ok(display) };
        if self.alpha {
            return Err(PyValueError::new_err("background and alpha: expected one of them"));
        }
        let srgb = match given.extract::<Cow<'_, str>>().as_deref() {
            Ok("white") => [1.0; 3],
            Ok("black") => [0.0; 3],
            Ok(other) => {
                let line = format!(
                    "background: {other:?}, expected \"white\", \"black\" or three numbers"
                );
                return Err(PyValueError::new_err(line));
            }
            Err(_) => fixed(given, "background")?,
        };
        if !srgb.iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err(PyValueError::new_err(format!("background: {srgb:?}, expected 0 to 1")));
        }
        Ok(Display { background: display.color_space.from_srgb(srgb), ..display })
    }

    /// Renders without Python.
    fn run<T: Send>(
        &self,
        py: Python<'_>,
        opened: &Opened,
        (pixels, channels, depth): (&mut [T], usize, &mut [f32]),
        convert: impl Fn(&[f32; 4], &mut [T]) + Sync + Send,
    ) -> PyResult<()> {
        let usual = || Antialias::of(&opened.file().about);
        let antialias = self.antialias.map_or_else(usual, Antialias::Rays);
        let depth_wanted = !depth.is_empty();
        let settings =
            Settings { depth: depth_wanted, antialias, ..settings(opened, self.quality)? };
        without_python(py, || {
            let camera = opened.to_model(&self.camera, antialias);
            let mut renderer = Renderer::new(&opened.file().model, &settings);
            renderer.render_to(&camera, (pixels, channels, &mut *depth), convert)?;
            let scale = opened.file().about.scene.scale;
            if scale != 1.0 {
                depth.iter_mut().for_each(|depth| *depth *= scale);
            }
            Ok(())
        })?
        .map_err(refused)
    }
}

/// The array that was made for a result.
fn owned<T: numpy::Element>(pixels: PyReadwriteArrayDyn<'_, T>) -> Bound<'_, PyAny> {
    Bound::clone(&pixels).into_any()
}

/// By name or by the caller's array; `uint8` where nothing is said.
fn kind(dtype: Out<'_, '_>, out: Out<'_, '_>) -> PyResult<DType> {
    let name = |given: &Bound<'_, PyAny>| -> PyResult<String> {
        let dtype = given.py().import("numpy")?.call_method1("dtype", (given,))?;
        dtype.getattr("name")?.extract()
    };
    let found = match (dtype, out) {
        (Some(dtype), _) => name(dtype)?,
        (None, Some(out)) => {
            out.getattr("dtype").and_then(|d| d.getattr("name")?.extract()).unwrap_or_default()
        }
        (None, None) => "uint8".to_owned(),
    };
    match found.as_str() {
        "uint8" => Ok(DType::U8),
        "float32" => Ok(DType::F32),
        // What is no array is refused with the array that is expected.
        "" => Ok(DType::U8),
        other => Err(PyValueError::new_err(format!("dtype: {other}, expected uint8 or float32"))),
    }
}

fn settings(opened: &Opened, quality: Option<f32>) -> PyResult<Settings> {
    let usual = Settings::default();
    let quality = quality.or(opened.file().about.quality).unwrap_or(usual.quality);
    if !(0.0..=1.0).contains(&quality) {
        return Err(PyValueError::new_err(format!("quality: {quality}, expected 0 to 1")));
    }
    Ok(Settings { quality, ..usual })
}

/// How depth is rendered.
pub(super) struct Depth {
    pub(super) quality: Option<f32>,
    /// In the dataset's coordinates.
    pub(super) camera: Camera,
}

pub(super) fn depth<'py>(
    py: Python<'py>,
    opened: &Opened,
    how: &Depth,
    out: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [how.camera.height as usize, how.camera.width as usize];
    let mut depth = output::<f32>(py, out.as_ref(), &shape, ("out", "float32"))?;
    let pixels =
        Pixels { quality: how.quality, alpha: true, antialias: Some(1), camera: how.camera };
    // Pixels without size need no memory.
    let mut nothing = vec![(); shape[0] * shape[1]];
    pixels.run(py, opened, (&mut nothing, 1, depth.as_slice_mut()?), |_, _| ())?;
    Ok(out.unwrap_or_else(|| owned(depth)))
}

pub(super) fn normals<'py>(
    py: Python<'py>,
    opened: &Opened,
    camera: &Camera,
    out: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [camera.height as usize, camera.width as usize, 3];
    let mut normals = output::<f32>(py, out.as_ref(), &shape, ("out", "float32"))?;
    let to = normals.as_slice_mut()?.as_chunks_mut::<3>().0;
    let file = opened.file();
    without_python(py, || {
        let camera = opened.to_model(camera, Antialias::Off);
        picture::normals(&file.model, &camera, &Settings::default(), to)?;
        let similarity = file.about.scene.similarity();
        to.iter_mut().for_each(|normal| *normal = similarity.to_dataset_direction(*normal));
        Ok(())
    })?
    .map_err(|error: Error| refused(error))?;
    Ok(out.unwrap_or_else(|| owned(normals)))
}
