//! Which training cameras are near to a direction, as a point of the scene sees them.

use glam::Vec3;
use pocketnerf_core::Camera;

use crate::random::{Random, normal};

/// Directions turn within the angle to the camera that is so many-th nearest, seen from the
/// point: such directions lie between training views.
const NEIGHBOUR: usize = 4;
/// Fewer cameras than this have nothing between them.
pub(crate) const FEWEST: usize = NEIGHBOUR + 1;
/// Directions turn by no more than this, radians.
const MOST: f32 = 0.5;

/// The angle within which a direction may turn at a point; with fewer than [`FEWEST`] cameras the
/// largest.
pub(crate) fn reach(cameras: &[Camera], point: Vec3, direction: Vec3) -> f32 {
    let cosine = |camera: &Camera| direction.dot(towards(camera, point));
    let mut cosines: Vec<f32> = cameras.iter().map(cosine).collect();
    if cosines.len() < FEWEST {
        return MOST;
    }
    // The first is the ray's own camera.
    let (_, nth, _) = cosines.select_nth_unstable_by(NEIGHBOUR, |a, b| b.total_cmp(a));
    nth.clamp(-1.0, 1.0).acos().min(MOST)
}

/// A direction turned any way by up to an angle.
pub(crate) fn turn(direction: Vec3, reach: f32, random: &mut Random) -> Vec3 {
    let any = Vec3::new(normal(random), normal(random), normal(random));
    let across = any.reject_from_normalized(direction).normalize_or_zero();
    let angle = reach * random.next_f32();
    (direction * angle.cos() + across * angle.sin()).normalize()
}

/// Directions towards a point from the `N` cameras that are nearest to a direction there, in any
/// order.
pub(crate) fn nearest<const N: usize>(
    cameras: &[Camera],
    point: Vec3,
    direction: Vec3,
) -> Option<[Vec3; N]> {
    let mut all: Vec<Vec3> = cameras.iter().map(|camera| towards(camera, point)).collect();
    if N < all.len() {
        all.select_nth_unstable_by(N, |a, b| b.dot(direction).total_cmp(&a.dot(direction)));
    }
    all.first_chunk().copied()
}

/// The direction from a camera to a point.
fn towards(camera: &Camera, point: Vec3) -> Vec3 {
    (point - Vec3::from(camera.position())).normalize_or_zero()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A camera of one pixel, so many degrees around the origin, which it looks at from 4 units.
    pub(crate) fn at(degrees: f32) -> Camera {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let pose = Camera::look_at([4.0 * cos, 4.0 * sin, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        Camera::from_fov_x(1, 1, 0.7, pose)
    }

    /// The direction in which it sees the origin.
    fn seen_from(degrees: f32) -> Vec3 {
        -Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0)
    }

    #[test]
    fn directions_turn_as_far_as_neighbours_are() {
        let cameras = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0].map(at);
        let reach = |degrees| reach(&cameras, Vec3::ZERO, seen_from(degrees));
        // Of the first, the fourth nearest is 40 degrees away, which is too far; of the third 20.
        assert_eq!(reach(0.0), MOST);
        assert!((reach(20.0).to_degrees() - 20.0).abs() < 0.1, "{}", reach(20.0));
        let few = super::reach(&cameras[..FEWEST - 1], Vec3::ZERO, seen_from(20.0));
        assert_eq!(few, MOST);
        let mut random = Random::new(1, [0; 3]);
        for _ in 0..100 {
            let turned = turn(Vec3::X, 0.3, &mut random);
            assert!(turned.is_normalized() && turned.angle_between(Vec3::X) < 0.3 + 1e-3);
        }
    }

    #[test]
    fn the_nearest_cameras_are_those_around_a_direction() {
        let cameras = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0].map(at);
        let found = nearest::<2>(&cameras, Vec3::ZERO, seen_from(24.0)).unwrap();
        for degrees in [20.0, 30.0] {
            assert!(found.iter().any(|d| d.angle_between(seen_from(degrees)) < 1e-3), "{degrees}");
        }
        assert_eq!(nearest::<7>(&cameras, Vec3::ZERO, seen_from(24.0)), None);
        assert!(nearest::<6>(&cameras, Vec3::ZERO, seen_from(24.0)).is_some());
    }
}
