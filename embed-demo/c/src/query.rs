//! Queries, in the caller's coordinates and units.

use pocketnerf_core::Probe;
use pocketnerf_core::query::{Depth as CoreDepth, normal};

use crate::border;
use crate::model::Model;
use crate::options::{Options, unknown};
use crate::status::{Error, Failure, Status, call};

/// Definition of the depth along a ray.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// The expected depth, as in a rendered picture.
    Expected = 0,
    /// Where half of the light is absorbed.
    Median = 1,
    /// The first sample whose sigma exceeds the threshold, 1 / unit; finds transparent objects
    /// too (Dex-NeRF).
    FirstSigma = 2,
    /// Where the fraction `threshold` of the light, from 1e-6 to below 1, is absorbed.
    FirstOpacity = 3,
}

/// A list of query arguments: pointer, length, name.
type Questions<'n> = (*const f32, usize, &'n str);
/// Where the answers go.
type Answers<'n> = (*mut f32, &'n str);
/// The caller's scratch, and its length.
type Scratch = (*mut f32, usize);

/// Answers `n` queries `Q` with one `A` each.
///
/// # Safety
/// `Q` and `A` are made of `f32` and nothing else, in the order of their fields; for the rest, the
/// crate's one condition.
unsafe fn each<Q, A>(
    (model, options): (*const Model, *const Options),
    (questions, n, name): Questions<'_>,
    (answers, name_of_answers): Answers<'_>,
    (scratch, scratch_length): Scratch,
    error: *mut Error,
    ask: impl FnOnce(&Probe<'_>, &[Q], &mut [f32], &mut [A]) -> Result<(), Failure>,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let probe = probe(model, options)?;
        let questions = border::list(questions.cast(), n, name)?;
        let scratch = border::room(scratch, scratch_length, "scratch")?;
        ask(&probe, questions, scratch, border::room(answers.cast(), n, name_of_answers)?)
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// # Safety
/// `model` and `options` as [`border::read`] has it, but `options` may be null.
pub(crate) unsafe fn probe<'c>(
    model: *const Model,
    options: *const Options,
) -> Result<Probe<'c>, Failure> {
    // SAFETY: the caller's promise.
    let (model, options): (&Model, Options) =
        unsafe { (border::read(model, "model")?, Options::read(options)?) };
    let probe = Probe::new(&model.file().model, options.simd()?, options.tuning()?)?;
    Ok(probe.with_similarity(model.similarity())?)
}

/// Sigma at `n` points, three numbers each: one value each to `sigma`, the fraction of light
/// absorbed per unit of length, 1 / unit; 0 in empty space.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_density(
    model: *const Model,
    options: *const Options,
    points: *const f32,
    n: usize,
    sigma: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let (whose, points, place) = ((model, options), (points, n, "points"), (sigma, "sigma"));
    // SAFETY: the caller's promise.
    unsafe {
        each(
            whose,
            points,
            place,
            (scratch, scratch_length),
            error,
            |probe, points, scratch, out| Ok(probe.density(points, scratch, out)?),
        )
    }
}

/// Colour and sigma at `n` points, three numbers each, seen along `directions`, three numbers
/// each: four values each to `rgb_sigma`. Red, green and blue are 0 to 1, not premultiplied, in
/// the model's own colour space; sigma is in 1 / unit. All are 0 in empty space.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_radiance(
    model: *const Model,
    options: *const Options,
    points: *const f32,
    directions: *const f32,
    n: usize,
    rgb_sigma: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let (whose, points) = ((model, options), (points, n, "points"));
    let place = (rgb_sigma, "rgb_sigma");
    // SAFETY: the caller's promise.
    unsafe {
        each(
            whose,
            points,
            place,
            (scratch, scratch_length),
            error,
            |probe, points, scratch, out| {
                let directions = border::list(directions.cast(), n, "directions")?;
                Ok(probe.radiance(points, directions, scratch, out)?)
            },
        )
    }
}

/// The gradient of sigma at `n` points, three numbers each: three values each to `gradient`,
/// 1 / unit^2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_density_gradient(
    model: *const Model,
    options: *const Options,
    points: *const f32,
    n: usize,
    gradient: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let (whose, points, place) = ((model, options), (points, n, "points"), (gradient, "gradient"));
    // SAFETY: the caller's promise.
    unsafe {
        each(
            whose,
            points,
            place,
            (scratch, scratch_length),
            error,
            |probe, points, scratch, out| Ok(probe.density_gradient(points, scratch, out)?),
        )
    }
}

/// Surface normals at `n` points, three numbers each: a unit vector each to `normals`, three
/// numbers; zero where sigma has no gradient.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_normals(
    model: *const Model,
    options: *const Options,
    points: *const f32,
    n: usize,
    normals: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let (whose, points, place) = ((model, options), (points, n, "points"), (normals, "normals"));
    // SAFETY: the caller's promise.
    unsafe {
        each(
            whose,
            points,
            place,
            (scratch, scratch_length),
            error,
            |probe, points, scratch, out| {
                probe.density_gradient(points, scratch, out)?;
                out.iter_mut().for_each(|v| *v = normal(*v));
                Ok(())
            },
        )
    }
}

/// Whether `n` points, three numbers each, lie in occupied cells: one byte each to `occupied`,
/// 0 or 1. NaN counts as occupied.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_occupied(
    model: *const Model,
    points: *const f32,
    n: usize,
    occupied: *mut u8,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let probe = probe(model, std::ptr::null())?;
        let points: &[[f32; 3]] = border::list(points.cast(), n, "points")?;
        let out = border::room(occupied, n, "occupied")?.iter_mut();
        out.zip(points).for_each(|(out, point)| *out = probe.occupied(*point).into());
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Whether `n` spheres, centre and radius in four numbers each, are free: one byte each to
/// `clear`, 1 if no occupied cell touches the sphere, else 0. The answer is conservative: it
/// is never wrongly 1. NaN is not clear.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_sphere_clear(
    model: *const Model,
    balls: *const f32,
    n: usize,
    clear: *mut u8,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let probe = probe(model, std::ptr::null())?;
        let balls: &[[f32; 4]] = border::list(balls.cast(), n, "balls")?;
        let out = border::room(clear, n, "clear")?.iter_mut();
        out.zip(balls).for_each(|(out, [x, y, z, radius])| {
            *out = probe.sphere_clear([*x, *y, *z], *radius).into();
        });
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Transmittance of `n` segments, two points in six numbers each: one value each to `passes`,
/// 1 if nothing is in the way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_segment_transmittance(
    model: *const Model,
    options: *const Options,
    segments: *const f32,
    n: usize,
    passes: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let (whose, place) = ((model, options), (passes, "passes"));
    let segments = (segments, n, "segments");
    // SAFETY: the caller's promise.
    unsafe {
        each(
            whose,
            segments,
            place,
            (scratch, scratch_length),
            error,
            |probe, all, scratch, out| Ok(probe.segment_transmittance(all, scratch, out)?),
        )
    }
}

/// The probability that a body collides (CATNIPS): 1 - exp(-sum of sigma * volume /
/// particle_area) over the `n` points that fill it, three numbers each. Each point stands for
/// `volume`, unit^3; `particle_area`, unit^2, is the cross-section of the smallest relevant
/// obstacle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_collision_probability(
    model: *const Model,
    options: *const Options,
    points: *const f32,
    n: usize,
    volume: f32,
    particle_area: f32,
    probability: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let probe = probe(model, options)?;
        let points = border::list(points.cast(), n, "points")?;
        let scratch = border::room(scratch, scratch_length, "scratch")?;
        let found = probe.collision_probability(points, volume, particle_area, scratch)?;
        border::write(probability, found, "probability")
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Depths along `n` rays, origin and direction in six numbers each: one value each to `depths`,
/// units; infinite if there is none.
///
/// `kind` is a `PnrfDepth`, with its `threshold`. `axis`, three numbers, gives depths along that
/// direction, such as a camera's, instead of along the ray; null: along the ray.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_depths(
    model: *const Model,
    options: *const Options,
    rays: *const f32,
    n: usize,
    kind: u32,
    threshold: f32,
    axis: *const f32,
    depths: *mut f32,
    scratch: *mut f32,
    scratch_length: usize,
    error: *mut Error,
) -> Status {
    let depth = match kind {
        0 => Ok(CoreDepth::Expected),
        1 => Ok(CoreDepth::Median),
        2 => Ok(CoreDepth::FirstSigma(threshold)),
        3 => Ok(CoreDepth::FirstOpacity(threshold)),
        other => Err(unknown("kind", other)),
    };
    let (whose, rays, place) = ((model, options), (rays, n, "rays"), (depths, "depths"));
    // SAFETY: the caller's promise; a core `Ray` is its six numbers, in this order.
    unsafe {
        each(whose, rays, place, (scratch, scratch_length), error, |probe, rays, scratch, out| {
            let axis = border::read_or_none(axis.cast(), "axis")?.copied();
            Ok(probe.depths(rays, depth?, axis, scratch, out)?)
        })
    }
}
