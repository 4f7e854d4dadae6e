//! The widest gap between photographs.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use pocketnerf_core::Camera;

/// The [`widest_gap`] from which on what lies in it is a guess, degrees.
pub const GAP: f32 = 30.0;
/// Directions that are looked at.
const DIRECTIONS: usize = 2048;
/// Cameras surround a gap if they lie within so many times its radius ...
const AROUND: f32 = 1.25;
/// ... and no part of its circumference as long as this is without one.
const OPEN: f32 = 1.15 * PI;
/// What is wider lies outside: whoever takes photographs from above leaves the whole underside out.
const WIDEST: f32 = 0.25 * PI;

/// The largest angle by which a direction between those in which cameras look is away from all of
/// them, degrees; 0 where there is none. Directions beyond the outermost cameras do not count:
/// nobody took photographs there.
#[must_use]
pub fn widest_gap<'c>(cameras: impl IntoIterator<Item = &'c Camera>) -> f32 {
    let axes: Vec<Vec3> = cameras.into_iter().map(|camera| camera.axis().into()).collect();
    let gap = |direction: Vec3| {
        let angles: Vec<f32> = axes.iter().map(|axis| axis.angle_between(direction)).collect();
        let radius = angles.iter().copied().fold(PI, f32::min);
        let (u, v) = direction.any_orthonormal_pair();
        let near = axes.iter().zip(&angles).filter(|(_, angle)| **angle <= AROUND * radius);
        let mut around: Vec<f32> = near.map(|(axis, _)| axis.dot(v).atan2(axis.dot(u))).collect();
        around.sort_by(f32::total_cmp);
        let first = around.first().map(|first| first + TAU);
        let next = around.iter().skip(1).copied().chain(first);
        let open = around.iter().zip(next).map(|(here, next)| next - here).fold(0.0, f32::max);
        let is_between = around.len() >= 3 && open < OPEN && radius < WIDEST;
        if is_between { radius.to_degrees() } else { 0.0 }
    };
    directions().map(gap).fold(0.0, f32::max)
}

/// Evenly spread (a Fibonacci lattice).
fn directions() -> impl Iterator<Item = Vec3> {
    let golden = PI * (3.0 - 5f32.sqrt());
    (0..DIRECTIONS).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f32 / DIRECTIONS as f32;
        let (sin, cos) = (golden * i as f32).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cameras on a half sphere, as many as there are directions above the ground; none within so
    /// many degrees of a direction.
    fn half_sphere(cut: f32, around: Vec3) -> Vec<Camera> {
        let above = directions().step_by(20).filter(|from| from.z > 0.0);
        let kept = above.filter(|from| from.angle_between(around).to_degrees() >= cut);
        let pose = |from: Vec3| Camera::look_at((4.0 * from).into(), [0.0; 3], [0.0, 0.1, 1.0]);
        kept.map(|from| Camera::from_fov_x(1, 1, 0.7, pose(from))).collect()
    }

    #[test]
    fn a_gap_is_found_and_the_underside_is_none() {
        let side = Vec3::new(0.8, -0.6, 0.6).normalize();
        for around in [side, Vec3::Z, Vec3::new(0.3, 0.5, 0.8).normalize()] {
            let whole = widest_gap(&half_sphere(0.0, around));
            assert!(whole < 21.0, "{whole}");
            for cut in [25.0, 35.0] {
                let found = widest_gap(&half_sphere(cut, around));
                assert!((cut - 1.0..cut + 11.0).contains(&found), "{around} {cut}: {found}");
            }
        }
        assert_eq!(widest_gap(&half_sphere(0.0, side)[..2]), 0.0);
        assert_eq!(widest_gap(&[]), 0.0);
    }
}
