//! Directions between few views.
//!
//! Of few photographs, each is alone with its direction: a colour network may learn each by heart,
//! and geometry that is wrong may look right. So a ray is shaded as if it came from anywhere
//! within two thirds of the way to the neighbouring cameras: highlights that are narrower than what
//! lies between the cameras cannot be learnt from these anyway. Fields whose samples have colours
//! of their own see rays as they are.

use glam::Vec3;
use pocketnerf_core::Camera;

use super::group::Group;
use crate::trainer::pixels::neighbours::{reach, turn};

/// Directions turn within this share of the angle to the neighbouring cameras.
const SHARE: f32 = 0.65;

impl Group {
    /// The direction that a ray is shaded from: its own, or one between these cameras.
    pub(super) fn blurred_direction(&mut self, r: usize, few: Option<&[Camera]>) -> [f32; 3] {
        let (ray, accumulated) = (&self.rays[r].ray, &self.accumulated[r]);
        let (Some(cameras), Some(random)) = (few, &mut self.random) else {
            return ray.direction;
        };
        let direction = Vec3::from(ray.direction);
        let point = Vec3::from(ray.origin) + accumulated.expected_depth() * direction;
        turn(direction, SHARE * reach(cameras, point, direction), random).into()
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::march::composite::Accumulated;

    use super::*;
    use crate::dataset::View;
    use crate::random::Random;
    use crate::trainer::pixels::neighbours::tests::at;
    use crate::trainer::pixels::rays::{Backdrop, Pixel, RaySource};

    #[test]
    fn directions_turn_between_few_cameras() {
        // Six cameras in a circle, 5 degrees apart, that look at the origin: the fourth nearest
        // neighbour of the last is 20 degrees away.
        let views = (0..6).map(|i| View::new("", at(5.0 * i as f32), vec![255; 4])).collect();
        let source = RaySource::new(views, Backdrop::Random);
        let mut random = Random::new(1, [0; 3]);
        let pixel = Pixel { view: 5, x: 0, y: 0 };
        let seen = Accumulated { opacity: 1.0, transmittance: 0.0, depth: 4.0 };
        let mut group = Group {
            rays: vec![source.ray(pixel, [255; 4], (0, 1.0), &mut random)],
            accumulated: vec![seen],
            random: Some(random),
            ..Group::default()
        };
        let own = Vec3::from(group.rays[0].ray.direction);
        let turned = |group: &mut Group, cameras| {
            let direction = Vec3::from(group.blurred_direction(0, cameras));
            assert!(direction.is_normalized());
            direction.angle_between(own).to_degrees()
        };
        assert!(turned(&mut group, None) < 1e-3);
        let angles: Vec<f32> =
            (0..200).map(|_| turned(&mut group, Some(source.cameras()))).collect();
        let largest = angles.iter().copied().fold(0.0, f32::max);
        assert!((12.0..13.1).contains(&largest), "{largest}");
        // Its own direction is none of them: they spread over what lies between.
        let mean = angles.iter().sum::<f32>() / angles.len() as f32;
        assert!((5.5..7.5).contains(&mean), "{mean}");
    }
}
