//! Cameras on a sphere, for models whose own cameras are not at hand.

use pocketnerf_core::{Camera, Space, math};

/// The angle that spreads any number of points evenly around an axis, radians.
const GOLDEN_ANGLE: f32 = 2.399_963;

/// `n` cameras that are spread evenly over a sphere around the middle of a space and look at it,
/// as far from it as the model's own camera, with its field of view, or at twice the longest side.
#[must_use]
pub fn sphere(space: &Space, own: Option<&Camera>, n: usize, side: u32) -> Vec<Camera> {
    let target = space.center();
    let radius = own.map_or(space.viewing_distance(), |camera| {
        let p = camera.position();
        (0..3).map(|a| (p[a] - target[a]).powi(2)).sum::<f32>().sqrt()
    });
    let fov_x = super::Circle::fov_x(own);
    let camera = |i: usize| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / n as f32;
        let across = (1.0 - z * z).max(0.0).sqrt();
        let angle = GOLDEN_ANGLE * i as f32;
        let direction = [across * math::cos(angle), across * math::sin(angle), z];
        let eye = [0, 1, 2].map(|a| target[a] + radius * direction[a]);
        Camera::from_fov_x(side, side, fov_x, Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
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
