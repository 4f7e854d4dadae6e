//! Cameras on a sphere, for models whose own cameras are not at hand.

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{Camera, Space};

use super::Circle;

/// The angle that spreads any number of points evenly around an axis, radians.
const GOLDEN_ANGLE: f32 = 2.399_963;

/// `n` cameras, evenly spread around the middle of a space, which they look at from as far away as
/// those of [`Circle::around`].
#[must_use]
pub fn sphere(space: &Space, own: Option<&Camera>, n: usize, side: u32) -> Vec<Camera> {
    let fov_x = Circle::fov_x(own);
    let first = Circle::around(space, own, n, fov_x).first;
    let camera = |i: usize| {
        let sine = 1.0 - (2.0 * i as f32 + 1.0) / n as f32;
        let (azimuth, elevation) = (GOLDEN_ANGLE * i as f32, sine.asin());
        Camera::from_fov_x(side, side, fov_x, Orbit { azimuth, elevation, ..first }.pose())
    };
    (0..n).map(camera).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_all_sides_at_one_distance() {
        let space = Space::Box { min: [0.0; 3], max: [2.0, 2.0, 4.0] };
        let cameras = sphere(&space, None, 40, 10);
        let mut mean = [0.0; 3];
        for camera in &cameras {
            let away = [0, 1, 2].map(|a| camera.position()[a] - space.center()[a]);
            let length = away.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((length - space.viewing_distance()).abs() < 1e-4);
            // The middle of the picture is the middle of the space.
            let seen = camera.project(space.center()).unwrap();
            assert!(seen.iter().all(|x| (x - 5.0).abs() < 1e-3), "{seen:?}");
            (0..3).for_each(|a| mean[a] += away[a] / length / 40.0);
        }
        assert!(mean.iter().all(|x| x.abs() < 0.05), "{mean:?}");
    }
}
