//! Questions to a model beside pictures, in the dataset's coordinates and units.

use numpy::PyArrayDyn;
use pocketnerf_core::query::Depth;
use pocketnerf_core::{Error, Probe, Ray, SimdLevel, Tuning};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use super::opened::Opened;
use crate::arrays::{Floats, Vectors, array};
use crate::errors::refused;
use crate::threads::without_python;

/// Questions that a thread takes at a time.
const CHUNK: usize = 4096;

type Answers<'py, T> = PyResult<Bound<'py, PyArrayDyn<T>>>;

/// Asks with scratch, on all threads of the current pool.
fn each<Q: Sync, A: Send>(
    opened: &Opened,
    questions: &[Q],
    answers: &mut [A],
    ask: impl Fn(&Probe<'_>, &[Q], &mut [f32], &mut [A]) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    let probe = opened.file().probe(SimdLevel::detect(), Tuning::FAST)?;
    let scratch = || vec![0.0; probe.scratch_len()];
    questions
        .par_chunks(CHUNK)
        .zip(answers.par_chunks_mut(CHUNK))
        .try_for_each_init(scratch, |scratch, (questions, answers)| {
            ask(&probe, questions, scratch, answers)
        })
}

/// The same without Python, to new memory.
fn answers<Q: Sync, A: Clone + Default + Send>(
    py: Python<'_>,
    opened: &Opened,
    questions: &[Q],
    ask: impl Fn(&Probe<'_>, &[Q], &mut [f32], &mut [A]) -> Result<(), Error> + Sync + Send,
) -> PyResult<Vec<A>> {
    let answers = without_python(py, || {
        let mut answers = vec![A::default(); questions.len()];
        each(opened, questions, &mut answers, ask).map(|()| answers)
    });
    answers?.map_err(refused)
}

pub(super) fn density<'py>(
    py: Python<'py>,
    opened: &Opened,
    points: &Vectors<'py>,
) -> Answers<'py, f32> {
    let found = answers(py, opened, points.get()?, |probe, points, scratch, out: &mut [f32]| {
        probe.density(points, scratch, out)
    });
    array(py, found?, points.shape())
}

pub(super) fn density_gradient<'py>(
    py: Python<'py>,
    opened: &Opened,
    points: &Vectors<'py>,
) -> Answers<'py, f32> {
    let found =
        answers(py, opened, points.get()?, |probe, points, scratch, out: &mut [[f32; 3]]| {
            probe.density_gradient(points, scratch, out)
        });
    array(py, found?.into_flattened(), &[points.shape(), &[3]].concat())
}

/// Colours and sigma.
pub(super) fn radiance<'py>(
    py: Python<'py>,
    opened: &Opened,
    points: &Vectors<'py>,
    directions: &Vectors<'py>,
) -> PyResult<(Floats<'py>, Floats<'py>)> {
    let pairs = pairs(points, directions)?;
    let found = answers(py, opened, &pairs, |probe, pairs, scratch, out: &mut [[f32; 4]]| {
        let (points, directions): (Vec<_>, Vec<_>) = pairs.iter().map(|[p, d]| (*p, *d)).unzip();
        probe.radiance(&points, &directions, scratch, out)
    })?;
    let color = found.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let sigma = found.iter().map(|[.., sigma]| *sigma).collect();
    let shape = points.shape();
    Ok((array(py, color, &[shape, &[3]].concat())?, array(py, sigma, shape)?))
}

pub(super) fn transmittance<'py>(
    py: Python<'py>,
    opened: &Opened,
    starts: &Vectors<'py>,
    ends: &Vectors<'py>,
) -> Answers<'py, f32> {
    let segments = pairs(starts, ends)?;
    let found = answers(py, opened, &segments, |probe, segments, scratch, out: &mut [f32]| {
        probe.segment_transmittance(segments, scratch, out)
    });
    array(py, found?, starts.shape())
}

pub(super) fn ray_depths<'py>(
    py: Python<'py>,
    opened: &Opened,
    (origins, directions): (&Vectors<'py>, &Vectors<'py>),
    (kind, threshold): (&str, Option<f32>),
) -> Answers<'py, f32> {
    let depth = match (kind, threshold) {
        ("expected", None) => Depth::Expected,
        ("median", None) => Depth::Median,
        ("first_sigma", Some(sigma)) => Depth::FirstSigma(sigma),
        ("first_opacity", Some(opacity)) => Depth::FirstOpacity(opacity),
        ("expected" | "median", Some(_)) => {
            return Err(PyValueError::new_err(format!("threshold: {kind} depth has none")));
        }
        ("first_sigma" | "first_opacity", None) => {
            return Err(PyValueError::new_err(format!("{kind}: expected a threshold")));
        }
        _ => {
            return Err(PyValueError::new_err(format!(
                "kind: {kind:?}, expected expected, median, first_sigma or first_opacity"
            )));
        }
    };
    let rays = pairs(origins, directions)?;
    let rays: Vec<Ray> =
        rays.into_iter().map(|[origin, direction]| Ray { origin, direction }).collect();
    let found = answers(py, opened, &rays, |probe, rays, scratch, out: &mut [f32]| {
        probe.depths(rays, depth, None, scratch, out)
    });
    array(py, found?, origins.shape())
}

pub(super) fn occupied<'py>(
    py: Python<'py>,
    opened: &Opened,
    points: &Vectors<'py>,
) -> Answers<'py, bool> {
    let found = answers(py, opened, points.get()?, |probe, points, _, out: &mut [bool]| {
        out.iter_mut().zip(points).for_each(|(out, point)| *out = probe.occupied(*point));
        Ok(())
    });
    array(py, found?, points.shape())
}

pub(super) fn sphere_clear<'py>(
    py: Python<'py>,
    opened: &Opened,
    centers: &Vectors<'py>,
    radii: &[f32],
) -> Answers<'py, bool> {
    let balls: Vec<_> = centers.get()?.iter().copied().zip(radii.iter().copied()).collect();
    let found = answers(py, opened, &balls, |probe, balls, _, out: &mut [bool]| {
        let clear = |(center, radius): &([f32; 3], f32)| probe.sphere_clear(*center, *radius);
        out.iter_mut().zip(balls).for_each(|(out, ball)| *out = clear(ball));
        Ok(())
    });
    array(py, found?, centers.shape())
}

/// Of one body, whose points are not shared out: their sum is in one order.
pub(super) fn collision_probability(
    py: Python<'_>,
    opened: &Opened,
    points: &Vectors<'_>,
    volume: f32,
    particle_area: f32,
) -> PyResult<f32> {
    let points = points.get()?;
    let found = py.detach(|| {
        let probe = opened.file().probe(SimdLevel::detect(), Tuning::FAST)?;
        let mut scratch = vec![0.0; probe.scratch_len()];
        probe.collision_probability(points, volume, particle_area, &mut scratch)
    });
    found.map_err(refused)
}

fn pairs(a: &Vectors<'_>, b: &Vectors<'_>) -> PyResult<Vec<[[f32; 3]; 2]>> {
    a.expect_same(b)?;
    Ok(a.get()?.iter().zip(b.get()?).map(|(a, b)| [*a, *b]).collect())
}
