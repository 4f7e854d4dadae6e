//! Cameras, in the caller's coordinates.

use pocketnerf_core::Camera as CoreCamera;

use crate::border;
use crate::model::Model;
use crate::status::{Error, Failure, Status, call};

/// The largest width and height of a picture, pixels.
pub const MAX_SIDE: u32 = 16384;
const _: () = assert!(MAX_SIDE == CoreCamera::MAX_SIDE);

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
    /// Principal point in x and y, pixels from the top left corner. To render a part of a
    /// picture, move it and make the picture smaller.
    pub center: [f32; 2],
    /// 4x4 camera-to-world matrix, row after row: columns are right, up, back (unit
    /// vectors) and the camera's position. The last row is ignored.
    pub camera_to_world: [f32; 16],
}

impl Camera {
    /// Checked, in the caller's coordinates.
    pub(crate) fn checked(self) -> Result<CoreCamera, Failure> {
        let Self { width, height, focal, center, camera_to_world } = self;
        let camera = CoreCamera { width, height, focal, center, camera_to_world };
        camera.validate().map_err(|error| Failure::new(Status::Camera, error))?;
        Ok(camera)
    }

    /// Checked, in the coordinates of the model.
    pub(crate) fn to_model(self, model: &Model) -> Result<CoreCamera, Failure> {
        Ok(model.scene().camera_to_model(&self.checked()?))
    }
}

impl From<CoreCamera> for Camera {
    fn from(camera: CoreCamera) -> Self {
        let CoreCamera { width, height, focal, center, camera_to_world } = camera;
        Self { width, height, focal, center, camera_to_world }
    }
}

/// Makes a camera at `eye` that looks at `target`, three numbers each. `up` is the
/// approximate up direction, of any length; `fov_x` is the horizontal field of view in
/// radians, 0.01 to 3.1.
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
