//! Cameras, in the caller's coordinates.

use pocketnerf_core::query::is_rotation;
use pocketnerf_core::{Camera as CoreCamera, Space, math};
use pocketnerf_formats::MAX_PICTURE_SIDE;

use crate::border;
use crate::model::Model;
use crate::status::{Error, Failure, Status, call};

/// Pixels along a side of a picture at most.
pub const MAX_SIDE: u32 = 16384;
const _: () = assert!(MAX_SIDE == MAX_PICTURE_SIDE);

/// A pinhole camera. Axes are OpenGL's: x right, y up, looking along -z. The centre of the
/// upper left pixel is at (0.5, 0.5).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Picture width in pixels, 1 to `PNRF_MAX_SIDE`.
    pub width: u32,
    /// Picture height in pixels, 1 to `PNRF_MAX_SIDE`.
    pub height: u32,
    /// Focal lengths in x and y, pixels, above 0.
    pub focal: [f32; 2],
    /// Principal point in x and y, pixels from the top left corner. A part of a picture is
    /// taken by moving it and making the picture smaller.
    pub center: [f32; 2],
    /// 4x4 camera-to-world matrix, row after row: columns are right, up, back (unit
    /// vectors) and the camera's position. The last row is not read.
    pub camera_to_world: [f32; 16],
}

impl Camera {
    /// Checked, in the coordinates of the model.
    pub(crate) fn to_model(self, model: &Model) -> Result<CoreCamera, Failure> {
        let fail = |text: &str| Err(Failure::new(Status::Camera, text));
        let Self { width, height, focal, center, camera_to_world: m } = self;
        if [width, height].iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
            let text = format!("camera: {width}x{height} pixels, expected 1 to {MAX_SIDE} a side");
            return Err(Failure::new(Status::Camera, text));
        }
        if !focal.iter().all(|f| (1e-3..1e9).contains(f)) {
            return fail("camera: focal lengths, expected 0.001 to 1e9 pixels");
        }
        if !center.iter().all(|c| c.abs() < 1e9) {
            return fail("camera: principal point, expected pixels below 1e9");
        }
        if !is_rotation(&[0, 4, 8].map(|row| [m[row], m[row + 1], m[row + 2]])) {
            return fail(
                "camera: camera_to_world, expected unit vectors right, up and back, right-handed, in its columns",
            );
        }
        if ![m[3], m[7], m[11]].iter().all(|v| v.abs() <= 1e11) {
            return fail("camera: position, expected finite numbers");
        }
        let camera = CoreCamera { width, height, focal, center, camera_to_world: m };
        Ok(model.scene().camera_to_model(&camera))
    }
}

impl From<CoreCamera> for Camera {
    fn from(camera: CoreCamera) -> Self {
        let CoreCamera { width, height, focal, center, camera_to_world } = camera;
        Self { width, height, focal, center, camera_to_world }
    }
}

/// A camera at `eye` that looks at `target`, three numbers each. `up` is where up is in
/// the picture, roughly, of any length; `fov_x` the horizontal field of view in radians,
/// 0.01 to 3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_look_at(
    eye: *const f32,
    target: *const f32,
    up: *const f32,
    fov_x: f32,
    width: u32,
    height: u32,
    camera: *mut Camera,
    error: *mut Error,
) -> Status {
    let work = || {
        let vector = |pointer, name| {
            // SAFETY: the caller's promise.
            let v = unsafe { border::list(pointer, 3, name)? };
            match v.iter().all(|v: &f32| v.abs() <= 1e11) {
                true => Ok([v[0], v[1], v[2]]),
                false => Err(Failure::new(Status::Argument, format_args!("{name}: not finite"))),
            }
        };
        let (eye, target, up) = (vector(eye, "eye")?, vector(target, "target")?, vector(up, "up")?);
        if !(0.01..3.1).contains(&fov_x) {
            let text = format_args!("fov_x: {fov_x}, expected 0.01 to 3.1 radians");
            return Err(Failure::new(Status::Argument, text));
        }
        let pose = CoreCamera::look_at(eye, target, up);
        let made = CoreCamera::from_fov_x(width, height, fov_x, pose);
        // SAFETY: the caller's promise.
        unsafe { border::write(camera, made.into(), "camera") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// A camera that shows the model: the file's own view, or, where it has none, one from
/// aside and above. 0 for width and height: the file's own size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_default_camera(
    model: *const Model,
    width: u32,
    height: u32,
    camera: *mut Camera,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let model = unsafe { border::read(model, "model")? };
        let own = model.file().about.camera;
        let size = own.map_or([400; 2], |own| [own.width, own.height]);
        let [width, height] = if width == 0 && height == 0 { size } else { [width, height] };
        let pose = own.map(|own| (own.camera_to_world, own.fov_x));
        let (pose, fov_x) = pose.unwrap_or_else(|| aside(&model.file().model.space));
        let mut made = Camera::from(CoreCamera::from_fov_x(width, height, fov_x, pose));
        made.camera_to_world = to_caller(model, &pose);
        made.to_model(model)?;
        // SAFETY: the caller's promise.
        unsafe { border::write(camera, made, "camera") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// A pose and a field of view for a model without a view of its own, in its coordinates.
fn aside(space: &Space) -> ([f32; 16], f32) {
    #[cfg(feature = "ndc")]
    if let Space::Ndc(ndc) = space {
        // Where the photographs were taken from.
        let pose = CoreCamera::look_at([0.0; 3], [0.0, 0.0, -ndc.near], [0.0, 1.0, 0.0]);
        return (pose, 2.0 * (1.0 / ndc.slope[0]).atan());
    }
    let (target, distance) = (space.center(), 2.0 / space.unit_map().scale);
    let (sin, cos) = math::sin_cos(0.5);
    let eye = [target[0] + distance * cos, target[1], target[2] + distance * sin];
    (CoreCamera::look_at(eye, target, [0.0, 0.0, 1.0]), 0.7)
}

/// A pose of the model's coordinates in the caller's.
fn to_caller(model: &Model, pose: &[f32; 16]) -> [f32; 16] {
    let scene = model.scene();
    let position = scene.to_dataset([pose[3], pose[7], pose[11]]);
    let mut to = *pose;
    for (row, turn) in scene.rotation.iter().enumerate() {
        for column in 0..3 {
            to[4 * row + column] = (0..3).map(|i| turn[i] * pose[4 * i + column]).sum();
        }
        to[4 * row + 3] = position[row];
    }
    to
}
