//! What cameras look at.

use glam::{DMat3, DVec3};
use pocketnerf_core::{Camera, Space};

/// The point with the least sum of squared distances to the optical axes:
/// Σ (I − d dᵀ) p = Σ (I − d dᵀ) o.
#[must_use]
pub fn nearest_to_axes(poses: &[[f32; 16]]) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for pose in poses {
        let axis = DVec3::new(pose[2].into(), pose[6].into(), pose[10].into()).normalize();
        let across =
            DMat3::IDENTITY - DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        matrix += across;
        right += across * DVec3::new(pose[3].into(), pose[7].into(), pose[11].into());
    }
    // The determinant of the mean is 0 for parallel axes, at most 8/27.
    let n = poses.len() as f64;
    // Without cameras it is not a number.
    let apart = (matrix * (1.0 / n)).determinant() >= 1e-9;
    apart.then(|| matrix.inverse() * right)
}

/// The box of an object that the cameras look at, silhouettes unknown: a cube around the
/// point that they look at, as large as half the way to the nearest camera on every side.
pub(crate) fn object_box(cameras: &[Camera]) -> Space {
    let (center, distances) = distances(cameras);
    cube(center, 0.5 * distances.into_iter().fold(f32::INFINITY, f32::min))
}

/// The point that the cameras look at, and how far each is from it.
pub(crate) fn distances(cameras: &[Camera]) -> ([f32; 3], Vec<f32>) {
    let poses: Vec<[f32; 16]> = cameras.iter().map(|c| c.camera_to_world).collect();
    let center = nearest_to_axes(&poses).map_or([0.0; 3], |p| p.as_vec3().to_array());
    let distance = |c: &Camera| {
        let p = c.position();
        (0..3).map(|a| (p[a] - center[a]).powi(2)).sum::<f32>().sqrt()
    };
    (center, cameras.iter().map(distance).collect())
}

/// A cube around a point; one unit to each side if it has no size.
pub(crate) fn cube(center: [f32; 3], half: f32) -> Space {
    let half = if half.is_finite() && half > 5e-4 { half } else { 1.0 };
    Space::Box { min: center.map(|c| c - half), max: center.map(|c| c + half) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_that_meet_and_axes_that_do_not() {
        let target = [1.0, 2.0, 3.0];
        let poses: Vec<_> = [[5.0, 2.0, 3.0], [1.0, 9.0, 3.5], [0.0, 0.0, 8.0]]
            .into_iter()
            .map(|eye| Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
            .collect();
        let point = nearest_to_axes(&poses).unwrap();
        assert!(point.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-5, "{point}");
        assert_eq!(nearest_to_axes(&poses[..1]), None);
        assert_eq!(nearest_to_axes(&[]), None);
    }
}
