//! From the gradients of samples and directions to the pull on each camera.
//!
//! A sample stays where it is on its ray. So a camera that moves takes it along, and one that
//! turns swings it about itself: the pull on a camera is the sum of its samples' gradients, a
//! force, and of their torques about it.

use std::ops::AddAssign;

use pocketnerf_core::encoding::hash_grid::MAX_LEVELS;
use pocketnerf_core::space::{Contracted, UnitMap};
use pocketnerf_core::{Ray, Space};

use super::group::{Group, Kept, STRIDE};
use crate::field::harmonics;

/// The force on a camera and the torque about it: gradients by a shift, scene units, and by a
/// turn, radians.
pub(crate) type Pull = [f32; 6];

/// What of a step's poses a group needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseJob {
    /// How much the gradient through each level of a grid counts.
    pub(crate) levels: [f32; MAX_LEVELS],
    /// Photographs.
    pub(crate) views: usize,
}

impl Group {
    /// No camera is pulled yet.
    pub(super) fn release_cameras(&mut self, poses: &PoseJob) {
        self.pulls.clear();
        self.pulls.resize(poses.views, Pull::default());
    }

    /// Adds what the positions of samples pull at their cameras.
    pub(super) fn pull(&mut self, kept: &[Kept], d_points: [&[f32]; 3], space: &Space) {
        let map = space.unit_map();
        for (column, k) in kept.iter().enumerate() {
            let record = &self.records[k.sample as usize];
            let r = record.ray as usize;
            let slope = d_points.map(|row| row[column]);
            let pull = in_scene(space, &map, &self.rays[r].ray, record.point, slope);
            add(&mut self.pulls[self.pixels[r].view as usize], pull);
        }
    }

    /// Adds what the directions of rays pull, on which colours depend: `d_harmonics` is the
    /// gradient of the harmonics of the `directions`.
    pub(super) fn pull_directions(
        &mut self,
        hits: &[usize],
        directions: [&[f32]; 3],
        d_harmonics: &[f32],
        degree: u32,
    ) {
        for (column, r) in hits.iter().enumerate() {
            let direction = directions.map(|row| row[column]);
            let slopes = d_harmonics.chunks(STRIDE).map(|row| row[column]);
            let slope = harmonics::gradient(degree, direction, slopes);
            let [x, y, z] = cross(direction, slope);
            add(&mut self.pulls[self.pixels[*r].view as usize], [0.0, 0.0, 0.0, x, y, z]);
        }
    }
}

fn add(sum: &mut Pull, pull: Pull) {
    sum.iter_mut().zip(pull).for_each(|(sum, pull)| sum.add_assign(pull));
}

/// The pull of a sample at unit point `u` with the gradient `slope` by it.
fn in_scene(space: &Space, map: &UnitMap, ray: &Ray, u: [f32; 3], slope: [f32; 3]) -> Pull {
    let local = [0, 1, 2].map(|a| map.min[a] + u[a] / map.scale);
    let slope = slope.map(|d| d * map.scale);
    let point = space.scene_point(local);
    let force = match space {
        // x' = -ax x / z, y' = -ay y / z, z' = 1 + 2 n / z.
        Space::Ndc(ndc) => {
            let along = local[0] * slope[0] + local[1] * slope[1] + (local[2] - 1.0) * slope[2];
            let [x, y] = [0, 1].map(|a| ndc.slope[a] * slope[a]);
            [x, y, along].map(|d| -d / point[2])
        }
        Space::Contracted(contracted) => by_scene_point(contracted, local, slope),
        _ => slope,
    };
    let [x, y, z] = cross([0, 1, 2].map(|a| point[a] - ray.origin[a]), force);
    [force[0], force[1], force[2], x, y, z]
}

/// The gradient by a scene point, from that by its local one.
fn by_scene_point(space: &Contracted, local: [f32; 3], slope: [f32; 3]) -> [f32; 3] {
    let axis = (1..3).fold(0, |most, a| if local[a].abs() > local[most].abs() { a } else { most });
    let mut force = slope;
    if local[axis].abs() > 1.0 {
        // p'_a = (2 - 1/m) sign(q_a), p'_b = q_b / m, where m = |q_a|.
        let inverse = 2.0 - local[axis].abs();
        let across = (0..3).filter(|b| *b != axis).map(|b| slope[b] * local[b]).sum::<f32>();
        force = slope.map(|d| d * inverse);
        force[axis] = inverse * (inverse * slope[axis] - local[axis].signum() * across);
    }
    force.map(|d| d / space.radius)
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::space::Ndc;

    use super::*;

    /// A function of local points, and its gradient.
    fn height(p: [f32; 3]) -> f64 {
        let [x, y, z] = p.map(f64::from);
        x * y + 0.5 * y * z - z * x * x
    }

    fn slope(p: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = p;
        [y - 2.0 * z * x, x + 0.5 * z, 0.5 * y - x * x]
    }

    #[test]
    fn a_sample_swings_about_its_camera() {
        let ndc = Ndc { near: 0.5, slope: [1.0, 2.0], min: [-1.0; 3], max: [1.0; 3] };
        let around = |radius| Space::Contracted(Contracted { center: [0.1, 0.2, -0.3], radius });
        let spaces = [
            Space::Box { min: [-2.0; 3], max: [1.0; 3] },
            Space::Ndc(ndc),
            // The point lies in the cube, and beyond it along -z.
            around(2.0),
            around(0.5),
        ];
        let ray = Ray { origin: [0.4, -0.2, 0.3], direction: [0.0, 0.0, -1.0] };
        // Where the sample is, scene units.
        let point = [0.3f32, 0.2, -1.4];
        for space in spaces {
            let map = space.unit_map();
            let local = |p: [f32; 3]| match &space {
                Space::Ndc(ndc) => [
                    -ndc.slope[0] * p[0] / p[2],
                    -ndc.slope[1] * p[1] / p[2],
                    1.0 + 2.0 * ndc.near / p[2],
                ],
                Space::Contracted(space) => space.local_point(p),
                _ => p,
            };
            let here = local(point);
            let by_unit = slope(here).map(|d| d / map.scale);
            let pull = in_scene(&space, &map, &ray, map.apply(here), by_unit);
            let arm = [0, 1, 2].map(|a| point[a] - ray.origin[a]);
            for (i, found) in pull.into_iter().enumerate() {
                let mut axis = [0.0; 3];
                axis[i % 3] = 1.0;
                let way = if i < 3 { axis } else { cross(axis, arm) };
                let moved = |by: f32| height(local([0, 1, 2].map(|a| point[a] + by * way[a])));
                let expected = (moved(1e-2) - moved(-1e-2)) / 2e-2;
                assert!((f64::from(found) - expected).abs() < 2e-3, "{i}: {found} {expected}");
            }
        }
    }
}
