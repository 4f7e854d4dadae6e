//! Questions beside pictures, in the caller's coordinates and units.

use pocketnerf_core::Probe;
use pocketnerf_core::query::{Depth as CoreDepth, normal};

use crate::border;
use crate::model::Model;
use crate::options::{Options, unknown};
use crate::status::{Error, Failure, Status, call};

/// What counts as the depth of a ray that sees more than one thing.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// The mean over what is seen, as in a rendered depth.
    Expected = 0,
    /// Where half of the light has been held back.
    Median = 1,
    /// The first sample with a sigma above the threshold, 1 / unit: transparent things
    /// too (Dex-NeRF).
    FirstSigma = 2,
    /// Where a part of the light, the threshold, from 1e-6 to below 1, has been held back.
    FirstOpacity = 3,
}

/// A list of things that is asked about.
type Questions<'n> = (*const f32, usize, &'n str);
/// Where as many answers go.
type Answers<'n> = (*mut f32, &'n str);
/// Values that are the caller's, and how many.
type Scratch = (*mut f32, usize);

/// Asks about many things, each a `Q`, into an `A` each.
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
unsafe fn probe<'c>(model: *const Model, options: *const Options) -> Result<Probe<'c>, Failure> {
    // SAFETY: the caller's promise.
    let (model, options): (&Model, Options) =
        unsafe { (border::read(model, "model")?, Options::read(options)?) };
    let probe = Probe::new(&model.file().model, options.simd()?, options.tuning()?)?;
    Ok(probe.with_similarity(model.similarity())?)
}

/// Sigma at `n` points, three numbers each, into one value each of `sigma`: the part of the
/// light held back per unit of length, 1 / unit; 0 where nothing is.
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

/// Colour and sigma of `n` points, three numbers each, seen along `directions`, three
/// numbers each, into four values each of `rgb_sigma`: red, green and blue, straight, 0 to 1,
/// and sigma, 1 / unit. All are 0 where nothing is.
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

/// The slope of sigma at `n` points, three numbers each, into three values each of
/// `gradient`, 1 / unit^2.
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

/// Where surfaces at `n` points face, three numbers each, into a unit vector each of `normals`,
/// three numbers; zeros where sigma has no slope.
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

/// Whether there may be something at `n` points, three numbers each, into one byte each of
/// `occupied`: 0 or 1. Points that are nowhere (NaN) count as occupied.
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

/// Whether `n` balls, centre and radius in four numbers each, are free, into one byte each of
/// `clear`: 1 where no occupied cell touches the ball, else 0. Never 1 by mistake; balls that are
/// nowhere (NaN) are not clear.
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

/// The part of the light that passes along `n` segments, from point to point in six numbers
/// each, into one value each of `passes`: 1 where nothing is in the way.
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

/// The probability that a body hits something (CATNIPS): 1 - exp(-sum of sigma * volume /
/// particle_area) over the `n` points that fill it, three numbers each, of which each stands
/// for `volume`, unit^3. `particle_area`, unit^2, says how large a thing must be to matter.
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

/// How far `n` rays see, origin and direction in six numbers each, into one value each of
/// `depths`, units; infinite where a ray sees nothing of the kind.
///
/// `kind`: a `PnrfDepth`, with its `threshold`. `axis`, three numbers: depths along that direction, such as
/// a camera's, instead of along the ray; null: along the ray.
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
