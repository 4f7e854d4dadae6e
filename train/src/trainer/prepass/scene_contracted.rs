//! The space of a scene without an end, from its cameras.

use pocketnerf_core::Camera;
use pocketnerf_core::space::Contracted;

use crate::cameras::distances;

/// Half of the cube's side, in largest offsets of a camera: where the cube ends near a camera,
/// rays bend in what it sees best.
const SIDE: f32 = 2.0;

/// Contracted space around what the cameras look at: its cube holds all the cameras, and half of
/// its side is twice as far as the farthest of them. `None`
/// where there is none, or all are in one place.
#[must_use]
pub fn contracted_of(cameras: &[Camera]) -> Option<Contracted> {
    let (center, _) = distances(cameras);
    let offsets = cameras.iter().map(|camera| {
        let p = camera.position();
        (0..3).map(|a| (p[a] - center[a]).abs()).fold(0.0, f32::max)
    });
    let radius = SIDE * offsets.fold(0.0, f32::max);
    (1e-6..1e6).contains(&radius).then_some(Contracted { center, radius })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_holds_the_cameras() {
        let eyes = [[3.0, 2.0, 3.0], [1.0, 6.0, 3.0], [1.0, 2.0, 9.0]];
        let cameras = eyes.map(|eye| {
            let pose = Camera::look_at(eye, [1.0, 2.0, 3.0], [0.1, 0.2, 0.9]);
            Camera::from_fov_x(8, 8, 1.0, pose)
        });
        let Contracted { center, radius } = contracted_of(&cameras).unwrap();
        assert!((0..3).all(|a| (center[a] - [1.0, 2.0, 3.0][a]).abs() < 1e-4), "{center:?}");
        assert!((radius - 12.0).abs() < 1e-4, "{radius}");
        assert_eq!(contracted_of(&[]), None);
    }
}
