//! Where the built-in scene is seen from.

use super::{HELD_OUT_VIEWS, SIZE, TRAIN_VIEWS};
use pocketnerf_core::{Camera, math};

/// Distance of every camera from the origin, which it looks at, scene units.
pub(super) const DISTANCE: f32 = 4.0;
/// Horizontal field of view in radians, as in the Blender NeRF scenes.
pub(super) const FOV_X: f32 = 0.691_111_2;
/// Angle between a training view and the next, seen from the origin, radians.
/// The turns of the spiral lie 15° apart.
const STEP: f32 = 0.44;
/// Sine of the elevation of the first and of the last view: −9° to 75°.
const SINE_RANGE: [f32; 2] = [-0.16, 0.966];

/// The training views climb a spiral of five turns around the scene, so that
/// view i + 1 is a neighbour of view i.
pub(super) fn train() -> Vec<Camera> {
    spiral().step_by(2).take(TRAIN_VIEWS).collect()
}

/// Held-out view j lies halfway between training views 5 j + 2 and 5 j + 3:
/// on the spiral, as far from all training views as a point near it can be.
pub(super) fn held_out() -> Vec<Camera> {
    spiral().skip(5).step_by(10).take(HELD_OUT_VIEWS).collect()
}

/// Points on the spiral, two for each training view. Sines of elevation are
/// evenly spaced, so that every view has an equal share of the sphere.
fn spiral() -> impl Iterator<Item = Camera> {
    let [low, high] = SINE_RANGE;
    let mut azimuth = 0.0;
    (0..2 * TRAIN_VIEWS).map(move |k| {
        let sine = low + (high - low) * k as f32 / (2 * TRAIN_VIEWS - 1) as f32;
        let cosine = math::sqrt(1.0 - sine * sine);
        let (s, c) = math::sin_cos(azimuth);
        azimuth += 0.5 * STEP / cosine;
        let eye = [cosine * c, cosine * s, sine].map(|x| x * DISTANCE);
        Camera::from_fov_x(SIZE, SIZE, FOV_X, Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]))
    })
}
