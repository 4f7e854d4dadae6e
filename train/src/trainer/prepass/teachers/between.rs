//! Cameras between those of few photographs, and a little beside them.

use glam::{Mat3, Quat, Vec3};
use pocketnerf_core::Camera;

/// Neighbours of each camera to which one lies half way.
const NEIGHBOURS: usize = 3;
/// The way from a camera to its nearest neighbour, backwards: where the photographs end.
const BESIDE: f32 = -0.5;

/// Half way between each camera and its nearest neighbours, and away from the nearest; each with the
/// number of the camera whose pixels it has.
pub(super) fn cameras(given: &[Camera]) -> Vec<(Camera, usize)> {
    let place = |i: usize| Vec3::from(given[i].position());
    let nearest = |i: usize| {
        let mut others: Vec<usize> = (0..given.len()).filter(|j| *j != i).collect();
        others.sort_by(|a, b| {
            let far = |j: &usize| place(i).distance_squared(place(*j));
            far(a).total_cmp(&far(b))
        });
        others
    };
    let mut pairs = Vec::new();
    for i in 0..given.len() {
        for j in nearest(i).into_iter().take(NEIGHBOURS) {
            let pair = (i.min(j), i.max(j));
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
    }
    let half_way = pairs.into_iter().map(|(i, j)| (on_the_way(&given[i], &given[j], 0.5), i));
    let beside = (0..given.len()).filter_map(|i| {
        let nearest = nearest(i).into_iter().next()?;
        Some((on_the_way(&given[i], &given[nearest], BESIDE), i))
    });
    half_way.chain(beside).collect()
}

/// The first camera after this share of its way to the second.
fn on_the_way(from: &Camera, to: &Camera, share: f32) -> Camera {
    let turn = |camera: &Camera| {
        let m = &camera.camera_to_world;
        let column = |c: usize| Vec3::new(m[c], m[4 + c], m[8 + c]);
        Quat::from_mat3(&Mat3::from_cols(column(0), column(1), column(2)))
    };
    let place = Vec3::from(from.position()).lerp(to.position().into(), share);
    let axes = Mat3::from_quat(turn(from).slerp(turn(to), share).normalize());
    let mut camera = *from;
    for (row, at) in place.to_array().into_iter().enumerate() {
        let axis = axes.row(row).to_array();
        camera.camera_to_world[4 * row..4 * row + 4]
            .copy_from_slice(&[axis[0], axis[1], axis[2], at]);
    }
    camera
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32, turned: f32) -> Camera {
        let pose =
            Camera::look_at([x, 0.0, 0.0], [x + turned.sin(), 0.0, -turned.cos()], [0.0, 1.0, 0.0]);
        Camera::from_fov_x(8, 6, 1.0, pose)
    }

    #[test]
    fn half_way_and_beside_by_hand() {
        let found = cameras(&[at(0.0, 0.0), at(1.0, 0.2), at(4.0, 0.0)]);
        // Three pairs, and one beside each.
        let places: Vec<f32> = found.iter().map(|(camera, _)| camera.position()[0]).collect();
        assert_eq!(places, [0.5, 2.0, 2.5, -0.5, 1.5, 5.5]);
        assert_eq!(found.iter().map(|(_, of)| *of).collect::<Vec<_>>(), [0, 0, 1, 0, 1, 2]);
        // Turned as far, too.
        for ((camera, _), turned) in found.iter().zip([0.1f32, 0.0, 0.1, -0.1, 0.3, -0.1]) {
            let [x, y, z] = camera.axis();
            let off = [x - turned.sin(), y, z + turned.cos()];
            assert!(off.iter().all(|v| v.abs() < 1e-5), "{turned}: {off:?}");
        }
        assert_eq!(found[0].0.focal, at(0.0, 0.0).focal);
        assert!(cameras(&[at(0.0, 0.0)]).is_empty());
    }
}
