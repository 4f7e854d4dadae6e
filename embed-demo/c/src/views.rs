//! Cameras that a model brings with it: its own view, around its centre, those of photographs.

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{Camera as CoreCamera, Space};

use crate::border;
use crate::camera::Camera;
use crate::model::Model;
use crate::status::{Error, Failure, Status, call};

/// The largest angle above or below the horizon, radians.
const STEEPEST: f32 = 1.57;

/// A width and height of 0 mean the file's own.
fn sized(model: &Model, width: u32, height: u32) -> [u32; 2] {
    let own = model.file().about.camera.map_or([800; 2], |own| [own.width, own.height]);
    if width == 0 && height == 0 { own } else { [width, height] }
}

/// The default camera, in the caller's coordinates.
fn own(model: &Model, width: u32, height: u32) -> CoreCamera {
    let [width, height] = sized(model, width, height);
    model.scene().camera_to_dataset(&model.file().camera(width, height))
}

/// Checks a camera and writes it.
///
/// # Safety
/// As [`border::write`].
unsafe fn give(model: &Model, made: CoreCamera, camera: *mut Camera) -> Result<(), Failure> {
    let made = Camera::from(made);
    made.to_model(model)?;
    // SAFETY: the caller's promise.
    unsafe { border::write(camera, made, "camera") }
}

/// Makes a camera that shows the model: the file's own view, or, if it has none, one from
/// the side and above. A width and height of 0 mean the file's own size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_default_camera(
    model: *const Model,
    width: u32,
    height: u32,
    camera: *mut Camera,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let model = border::read(model, "model")?;
        give(model, own(model, width, height), camera)
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Makes a camera that goes around the centre of the model and looks at it, with the field of view
/// of the default camera.
///
/// `azimuth` is the angle about `up`, radians, counter-clockwise seen from above; 0 is where the x
/// axis points, or the y axis if x is up. `elevation` is the angle above the horizon, -1.57 to
/// 1.57. `distance` is in the caller's units; 0: that of the default camera. `up`, three numbers
/// of any length; null: what the file says, else z. A width and height of 0 mean the file's own size. Forward-facing
/// captures have no back, and are refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_orbit_camera(
    model: *const Model,
    azimuth: f32,
    elevation: f32,
    distance: f32,
    up: *const f32,
    width: u32,
    height: u32,
    camera: *mut Camera,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let model: &Model = border::read(model, "model")?;
        let up = border::read_or_none(up.cast::<[f32; 3]>(), "up")?;
        let up = up.copied().unwrap_or_else(|| model.up());
        let wrong = |text: &str| Err(Failure::new(Status::Argument, text));
        if !(azimuth.is_finite() && elevation.abs() <= STEEPEST) {
            return wrong(
                "azimuth or elevation: not an angle, expected -1.57 to 1.57 for elevation",
            );
        }
        if !(0.0..=1e11).contains(&distance) {
            return wrong("distance: expected a length, or 0 for that of the default camera");
        }
        if up == [0.0; 3] || !up.iter().all(|v| v.abs() <= 1e11) {
            return wrong("up: expected a direction");
        }
        let space = &model.file().model.space;
        if matches!(space, Space::Ndc(_)) {
            let text = "a forward-facing capture has no back that a camera could go around to";
            return Err(Failure::new(Status::Unsupported, text));
        }
        let (own, target) = (own(model, width, height), model.scene().to_dataset(space.center()));
        let eye = own.position();
        let far = (0..3).map(|a| (eye[a] - target[a]).powi(2)).sum::<f32>().sqrt();
        let radius = if distance > 0.0 { distance } else { far };
        let orbit = Orbit { target, radius, azimuth, elevation, axis: up, up };
        give(model, CoreCamera { camera_to_world: orbit.pose(), ..own }, camera)
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Writes what the file says of the caller's coordinates: to `up` the direction that is up, three
/// numbers, a unit vector, z where the file says nothing; to `metres_per_unit` how long their unit
/// is, 0 where the file says nothing. Either may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_world(
    model: *const Model,
    up: *mut f32,
    metres_per_unit: *mut f32,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let model: &Model = border::read(model, "model")?;
        if !up.is_null() {
            border::write(up.cast::<[f32; 3]>(), model.up(), "up")?;
        }
        if !metres_per_unit.is_null() {
            border::write(metres_per_unit, model.metres_per_unit(), "metres_per_unit")?;
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// How many photographs' cameras the file has: an even choice of at most 64; 0 for null. People who
/// look from there see what photographs have seen.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_photograph_count(model: *const Model) -> u32 {
    let mut count = 0;
    let work = || {
        // SAFETY: the caller's promise.
        let model: &Model = unsafe { border::read(model, "model")? };
        count = model.file().about.photographs.map_or(0, |photographs| photographs.len() as u32);
        Ok(())
    };
    // SAFETY: no error is written.
    unsafe { call(std::ptr::null_mut(), work) };
    count
}

/// Makes the camera of a photograph, `number` from 0 to `pnrf_photograph_count` - 1, in the
/// dataset's order, with the median of their focal lengths. A width and height of 0 mean the file's
/// own size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_photograph_camera(
    model: *const Model,
    number: u32,
    width: u32,
    height: u32,
    camera: *mut Camera,
    error: *mut Error,
) -> Status {
    // SAFETY: the caller's promise.
    let work = || unsafe {
        let model: &Model = border::read(model, "model")?;
        let photographs = model.file().about.photographs;
        let n = photographs.map_or(0, |photographs| photographs.len());
        let found = photographs.and_then(|p| Some((p.focal, p.poses().nth(number as usize)?)));
        let Some((focal, pose)) = found else {
            let text = format_args!("number: {number} of {n} photographs, the first is 0");
            return Err(Failure::new(Status::Argument, text));
        };
        let [width, height] = sized(model, width, height);
        let made = CoreCamera {
            width,
            height,
            focal: [focal * width as f32; 2],
            center: [width, height].map(|side| 0.5 * side as f32),
            camera_to_world: pose,
        };
        give(model, model.scene().camera_to_dataset(&made), camera)
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}
