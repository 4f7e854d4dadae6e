//! The box of a scene, from its cameras and silhouettes.

use pocketnerf_core::{Camera, Space};

use crate::cameras::{cube, distances, object_box};
use crate::trainer::prepass::visual_hull::VisualHull;

/// Cells along an axis when looking for the box.
const RESOLUTION: u32 = 64;
/// Half of the side of a scene with its background, in mean distances of the cameras from
/// what they look at. What lies beyond is seen on the faces.
const BACKGROUND: f32 = 1.25;

/// The box around everything that the silhouettes allow, or, where there are none
/// (opaque images), one that holds the cameras and what is behind what they look at.
#[must_use]
pub fn find_box(cameras: &[Camera], hull: Option<&VisualHull>) -> Space {
    let Some(hull) = hull else { return background_box(cameras) };
    let around = object_box(cameras);
    let cells = hull.cells(&around, RESOLUTION);
    let ([min, max], map) = (around.bounds(), around.unit_map());
    let side = 1.0 / (RESOLUTION as f32 * map.scale);
    let (mut low, mut high) = (max, min);
    for cell in &cells {
        let corner = [cell % RESOLUTION, cell / RESOLUTION % RESOLUTION, cell / RESOLUTION.pow(2)];
        for a in 0..3 {
            low[a] = low[a].min(min[a] + corner[a] as f32 * side);
            high[a] = high[a].max(min[a] + (corner[a] + 1) as f32 * side);
        }
    }
    let found = Space::Box { min: low, max: high };
    if cells.is_empty() || found.validate().is_err() { around } else { found }
}

/// Opaque images show a background, wherever a ray ends: a cube that holds most of the
/// cameras too.
fn background_box(cameras: &[Camera]) -> Space {
    let (center, distances) = distances(cameras);
    cube(center, BACKGROUND * distances.iter().sum::<f32>() / distances.len() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_from_cameras_alone() {
        // Around (1, 2, 3), at distances of 2, 4 and 6.
        let eyes = [[3.0, 2.0, 3.0], [1.0, 6.0, 3.0], [1.0, 2.0, 9.0]];
        let cameras = eyes.map(|eye| {
            let pose = Camera::look_at(eye, [1.0, 2.0, 3.0], [0.1, 0.2, 0.9]);
            Camera::from_fov_x(8, 8, 1.0, pose)
        });
        let is_cube = |space: Space, half: f32| {
            let [min, max] = space.bounds();
            let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
            (0..3).all(|a| {
                let center = [1.0, 2.0, 3.0][a];
                near(min[a], center - half) && near(max[a], center + half)
            })
        };
        assert!(is_cube(object_box(&cameras), 1.0));
        assert!(is_cube(find_box(&cameras, None), 5.0));
        let nothing = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        assert_eq!(find_box(&[], None), nothing);
        assert_eq!(object_box(&[]), nothing);
    }
}
