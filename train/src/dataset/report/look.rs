//! Where cameras are and what they look at.

use glam::DVec3;
use pocketnerf_core::{Camera, Ray, Space};

use crate::cameras::object_box;
use crate::dataset::listing::Listing;

fn position(pose: &[f32; 16]) -> DVec3 {
    DVec3::new(pose[3].into(), pose[7].into(), pose[11].into())
}

/// Corners of the box around the cameras.
pub(super) fn camera_box(poses: &[[f32; 16]]) -> [[f32; 3]; 2] {
    let corner = |pick: fn(DVec3, DVec3) -> DVec3| {
        let point = poses.iter().map(position).reduce(pick).unwrap_or_default();
        point.as_vec3().to_array()
    };
    [corner(DVec3::min), corner(DVec3::max)]
}

/// Least and greatest distance of a camera from a point.
pub(super) fn distances(poses: &[[f32; 16]], point: DVec3) -> [f32; 2] {
    let of = poses.iter().map(|pose| position(pose).distance(point) as f32);
    [of.clone().fold(f32::INFINITY, f32::min), of.fold(0.0, f32::max)]
}

/// The box to look at: the dataset's own, that of its points, or that of an object, from the
/// cameras alone.
/// Forward-facing captures have none.
pub(super) fn scene_box(listing: &Listing) -> Option<[[f32; 3]; 2]> {
    if listing.forward_facing {
        return None;
    }
    listing.aabb.or(listing.reach).or_else(|| {
        // Only poses count.
        let camera = |pose| Camera::from_fov_x(1, 1, 1.0, pose);
        let cameras: Vec<Camera> = listing.frames.iter().map(|f| camera(f.pose)).collect();
        object_box(&cameras).scene_box()
    })
}

/// The share of cameras whose optical axes meet a box.
pub(super) fn share_looking_at(poses: &[[f32; 16]], [min, max]: [[f32; 3]; 2]) -> f64 {
    let meets = |m: &&[f32; 16]| {
        let ray = Ray { origin: [m[3], m[7], m[11]], direction: [-m[2], -m[6], -m[10]] };
        Space::Box { min, max }.intersect(&ray, 0.0, f32::MAX).is_some()
    };
    poses.iter().filter(meets).count() as f64 / poses.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_of_cameras_and_what_they_look_at() {
        let target = [1.0, 2.0, 3.0];
        let poses: Vec<_> = [[5.0, 2.0, 3.0], [1.0, 9.0, 3.5], [0.0, 0.0, 8.0]]
            .into_iter()
            .map(|eye| Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
            .collect();
        assert_eq!(camera_box(&poses), [[0.0, 0.0, 3.0], [5.0, 9.0, 8.0]]);
        // The first comes along x, the second along y, the third from above.
        let beside = [[0.0, 1.9, 2.9], [0.5, 2.1, 3.1]];
        assert_eq!(share_looking_at(&poses[..2], beside), 0.5);
        assert_eq!(share_looking_at(&poses, [[0.9, 1.9, 2.9], [1.1, 2.1, 3.1]]), 1.0);
    }
}
