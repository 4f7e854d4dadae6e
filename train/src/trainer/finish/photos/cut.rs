//! What the planes of a model hide.

use pocketnerf_core::{Camera, Model};

/// Share of the occupied cells that lie nearer than the model's `near` or farther than its `far`,
/// the mean over the cameras; 0 where there is no box.
pub(super) fn share(model: &Model<'_>, cameras: &[Camera]) -> f64 {
    let (Some(_), Some(occupancy)) = (model.space.scene_box(), model.occupancy) else { return 0.0 };
    let (map, resolution) = (model.space.unit_map(), occupancy.resolution());
    let side = 1.0 / (resolution as f32 * map.scale);
    let along = |cell: u32, axis: usize| map.min[axis] + (cell as f32 + 0.5) * side;
    let mut points = Vec::new();
    // Every second cell along each axis is enough.
    for z in (0..resolution).step_by(2) {
        for y in (0..resolution).step_by(2) {
            let cells = (0..resolution).step_by(2).filter(|x| occupancy.cell(*x, y, z));
            points.extend(cells.map(|x| glam::Vec3::new(along(x, 0), along(y, 1), along(z, 2))));
        }
    }
    let hidden = |camera: &Camera| {
        let eye = glam::Vec3::from(camera.position());
        let distances = points.iter().map(|point| point.distance(eye));
        let seen = model.sampling.near..model.sampling.far;
        distances.filter(|distance| !seen.contains(distance)).count()
    };
    let all = (points.len() * cameras.len()).max(1) as f64;
    cameras.iter().map(hidden).sum::<usize>() as f64 / all
}
