//! The space of a scene without an end, from its cameras.

use pocketnerf_core::Camera;
use pocketnerf_core::space::Contracted;

use crate::cameras::distances;

/// Half of the cube's side, in largest offsets of a camera, at most: where the cube ends near a
/// camera, rays bend in what it sees best.
const SIDE: f32 = 2.0;

/// Contracted space around what the cameras look at: its cube holds all the cameras, and reaches
/// twice as far, or, where the box `reach` of the scene's points is known and smaller, as far as
/// half of that is wide. `None` where there is no camera, or all are in one place.
#[must_use]
pub fn contracted_of(cameras: &[Camera], reach: Option<[[f32; 3]; 2]>) -> Option<Contracted> {
    let (center, _) = distances(cameras);
    let offsets = cameras.iter().map(|camera| {
        let p = camera.position();
        (0..3).map(|a| (p[a] - center[a]).abs()).fold(0.0, f32::max)
    });
    let farthest = offsets.fold(0.0, f32::max);
    let wide = |[min, max]: [[f32; 3]; 2]| (0..3).map(|a| max[a] - min[a]).fold(0.0, f32::max);
    let known = reach.map_or(f32::INFINITY, |reach| 0.5 * wide(reach));
    let radius = known.clamp(farthest, SIDE * farthest);
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
        let radius_of = |reach| contracted_of(&cameras, reach).map(|space| space.radius);
        let Contracted { center, radius } = contracted_of(&cameras, None).unwrap();
        assert!((0..3).all(|a| (center[a] - [1.0, 2.0, 3.0][a]).abs() < 1e-4), "{center:?}");
        assert!((radius - 12.0).abs() < 1e-4, "{radius}");
        // A box of points 16 wide, one that holds not even the cameras, and a larger one.
        for (side, radius) in [(8.0, 8.0), (3.0, 6.0), (40.0, 12.0)] {
            let found = radius_of(Some([[-1.0, 0.0, -side], [1.0, 1.0, side]])).unwrap();
            assert!((found - radius).abs() < 1e-4, "{found}");
        }
        assert_eq!(contracted_of(&[], None), None);
    }
}
