//! How far apart photographs are taken.

use glam::Vec3;
use pocketnerf_core::Camera;

/// The [`spacing`] from which on what lies between photographs is a guess, degrees: lego's 100 have
/// 11, 50 of them 16, 25 of them 24.
pub const WIDE: f32 = 26.0;

/// The median over cameras of the angle to the second nearest other camera, between the axes along
/// which they look, degrees. `None` for fewer than three cameras.
#[must_use]
pub fn spacing<'c>(cameras: impl IntoIterator<Item = &'c Camera>) -> Option<f32> {
    let axes: Vec<Vec3> = cameras.into_iter().map(|camera| camera.axis().into()).collect();
    let nearest = |i: usize| {
        let angles = axes.iter().map(|axis| axis.angle_between(axes[i]).to_degrees());
        let mut angles: Vec<f32> = angles.collect();
        angles.sort_by(f32::total_cmp);
        // The first is its own.
        angles.get(2).copied()
    };
    let mut angles: Vec<f32> = (0..axes.len()).filter_map(nearest).collect();
    angles.sort_by(f32::total_cmp);
    angles.get(angles.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_angle_to_the_second_nearest_camera() {
        let at = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let pose = Camera::look_at([4.0 * cos, 4.0 * sin, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
            Camera::from_fov_x(1, 1, 0.7, pose)
        };
        // Second nearest: 40, 30, 30, 50, 80.
        let cameras = [0.0, 10.0, 40.0, 60.0, 120.0].map(at);
        assert!((spacing(&cameras).unwrap() - 40.0).abs() < 0.01);
        assert_eq!(spacing(&cameras[..2]), None);
    }
}
