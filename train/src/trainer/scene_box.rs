//! The box of a scene, from its cameras and silhouettes.

use pocketnerf_core::{Camera, Space};

use super::hull::Hull;
use crate::dataset::nearest_to_axes;

/// Cells along an axis when looking for the box.
const RESOLUTION: u32 = 64;

/// The box around everything that the silhouettes allow, or, where they allow
/// all (opaque images), a box around what the cameras look at.
#[must_use]
pub fn find_box(cameras: &[Camera], hull: Option<&Hull>) -> Space {
    let around = cameras_box(cameras);
    let Some(hull) = hull else { return around };
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

/// A cube around the point that the cameras look at, as large as half the way
/// to the nearest camera on every side.
fn cameras_box(cameras: &[Camera]) -> Space {
    let poses: Vec<[f32; 16]> = cameras.iter().map(|c| c.camera_to_world).collect();
    let center = nearest_to_axes(&poses).map_or([0.0; 3], |p| p.as_vec3().to_array());
    let distance = |c: &Camera| {
        let p = c.position();
        (0..3).map(|a| (p[a] - center[a]).powi(2)).sum::<f32>().sqrt()
    };
    let nearest = cameras.iter().map(distance).fold(f32::INFINITY, f32::min);
    let half = if nearest.is_finite() && nearest > 1e-3 { nearest * 0.5 } else { 1.0 };
    Space::Box { min: center.map(|c| c - half), max: center.map(|c| c + half) }
}
