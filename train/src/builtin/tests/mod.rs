//! Tests of the built-in scenes.

mod scenes;
mod still_life;
mod village;

use glam::DVec3;
use pocketnerf_core::Camera;

/// Where the camera shows `p`, pixels from the top left corner.
fn project(camera: &Camera, p: DVec3) -> [f64; 2] {
    let m = camera.camera_to_world.map(f64::from);
    let v = p - DVec3::new(m[3], m[7], m[11]);
    let axis = |k: usize| v.dot(DVec3::new(m[k], m[4 + k], m[8 + k]));
    let depth = -axis(2);
    let focal = f64::from(camera.focal[0]);
    [
        f64::from(camera.center[0]) + focal * axis(0) / depth,
        f64::from(camera.center[1]) - focal * axis(1) / depth,
    ]
}
