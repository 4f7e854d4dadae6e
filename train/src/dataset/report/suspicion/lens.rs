//! Focal lengths and principal points that no photograph has.

use pocketnerf_core::Camera;

use super::super::shot::Shot;
use super::{Suspect, Suspicion};

/// Fields of view of lenses, the narrower side of the picture or the wider, degrees. Fisheyes may
/// be wider.
const FIELD: [f32; 2] = [3.0, 150.0];
/// How far the principal point may be from the middle, as a share of the side.
const OFF: f32 = 0.25;

pub(super) fn find(suspect: &Suspect<'_, '_>) -> Vec<Suspicion> {
    let mut found = Vec::new();
    let is_odd = |shot: &Shot<'_>| {
        fields(shot).into_iter().flatten().any(|field| !(FIELD[0]..=FIELD[1]).contains(&field))
    };
    let odd = suspect.which(is_odd);
    if let Some(first) = odd.first() {
        let [x, y] = fields(suspect.shots[*first]).map(Option::unwrap_or_default);
        let [least, most] = FIELD;
        found.push(Suspicion::new(
            "focal-length",
            format!(
                "{}, {x:.1} by {y:.1} degrees, expected {least} to {most}; correct the focal \
                 length, which is in pixels of images of the size w by h",
                suspect.some("fields of view that no photograph has", &odd)
            ),
        ));
        // What spoils one spoils the other.
        return found;
    }
    let off = suspect.which(|shot| shot.camera.is_some_and(is_off));
    if let Some(camera) = off.first().and_then(|first| suspect.shots[*first].camera) {
        let [x, y] = camera.center;
        found.push(Suspicion::new(
            "principal-point",
            format!(
                "{}, ({x:.0}, {y:.0}) in {}x{} pixels; if the cameras are those of larger images, \
                 give their w and h",
                suspect.some("principal points far from the middle", &off),
                camera.width,
                camera.height
            ),
        ));
    }
    found
}

/// Fields of view along both sides, degrees; none of a fisheye, or where the camera is not known.
fn fields(shot: &Shot<'_>) -> [Option<f32>; 2] {
    let name = shot.frame.lens.name();
    let is_wide = name.ends_with("fisheye") || name == "fov";
    let camera = shot.camera.filter(|_| !is_wide);
    [0, 1].map(|a| {
        let camera = camera?;
        let side = [camera.width, camera.height][a] as f32;
        Some((2.0 * (0.5 * side / camera.focal[a]).atan()).to_degrees())
    })
}

fn is_off(camera: Camera) -> bool {
    let sides = [camera.width as f32, camera.height as f32];
    (0..2).any(|a| (camera.center[a] / sides[a] - 0.5).abs() > OFF)
}
