//! What no photograph can tell: if all cameras turn, move and grow apart together, and the scene
//! with them, pictures stay the same.
//!
//! So whatever corrections have in common is taken out of them: they neither turn nor move nor
//! scale the cameras as a whole, and views that are not learnt from keep their poses.

use glam::DVec3;

use crate::cameras::mount::Mount;

/// What is shorter than this share of what it was is another's multiple.
const DEPENDENT: f64 = 1e-6;

/// Corrections that all cameras may have in common: unit vectors at right angles, each as long as
/// there are parameters.
#[derive(Clone, Debug)]
pub(super) struct Gauge(Vec<Vec<f64>>);

impl Gauge {
    /// Of these cameras: three turns, three shifts, and a scale.
    pub(super) fn new(mounts: &[Mount]) -> Self {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let all = |turn: DVec3, moved: &dyn Fn(DVec3) -> DVec3| -> Vec<f64> {
            mounts.iter().flat_map(|mount| mount.small(turn, moved)).collect()
        };
        let shifts = axes.map(|axis| all(DVec3::ZERO, &|_| axis));
        let turns = axes.map(|axis| all(axis, &|eye| axis.cross(eye)));
        let scale = all(DVec3::ZERO, &|eye| eye);
        let mut gauge = Self(Vec::new());
        for mut vector in shifts.into_iter().chain(turns).chain([scale]) {
            let before = length(&vector);
            // Twice: what rounding leaves.
            (0..2).for_each(|_| gauge.take_out(&mut vector));
            let after = length(&vector);
            if after > DEPENDENT * before {
                vector.iter_mut().for_each(|v| *v /= after);
                gauge.0.push(vector);
            }
        }
        gauge
    }

    /// Takes what corrections have in common out of them: the similarity by which all together are
    /// nearest to them.
    pub(super) fn fix(&self, parameters: &mut [f32]) {
        let mut values: Vec<f64> = parameters.iter().copied().map(f64::from).collect();
        self.take_out(&mut values);
        parameters.iter_mut().zip(values).for_each(|(parameter, value)| *parameter = value as f32);
    }

    fn take_out(&self, values: &mut [f64]) {
        for vector in &self.0 {
            let along: f64 = vector.iter().zip(&*values).map(|(a, b)| a * b).sum();
            values.iter_mut().zip(vector).for_each(|(value, v)| *value -= along * v);
        }
    }
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat};
    use pocketnerf_core::Camera;

    use super::super::PER_VIEW;
    use super::*;
    use crate::random::{Random, normal};

    fn cameras() -> [Camera; 4] {
        let eyes = [[3.0, 0.4, 0.8], [-1.2, 2.6, -0.7], [0.3, -1.0, 3.1], [2.0, 2.0, 2.0]];
        let pose = |eye| Camera::look_at(eye, [0.1, -0.3, 0.2], [0.0, 0.0, 1.0]);
        eyes.map(|eye| Camera::from_fov_x(8, 8, 0.7, pose(eye)))
    }

    fn mounts() -> Vec<Mount> {
        cameras().iter().map(|camera| Mount::new(camera, 2.5, 3.0)).collect()
    }

    #[test]
    fn a_similarity_of_all_cameras_is_no_correction() {
        let (turn, moved) = (DVec3::new(1e-3, -2e-3, 3e-3), DVec3::new(0.01, 0.02, -0.03));
        let place = |eye: DVec3| turn.cross(eye) + 5e-3 * eye + moved;
        let all: Vec<f64> = mounts().iter().flat_map(|mount| mount.small(turn, place)).collect();
        let mut parameters: Vec<f32> = all.iter().map(|v| *v as f32).collect();
        // They are that similarity, to first order.
        let rotation = DMat3::from_quat(DQuat::from_scaled_axis(turn));
        let rows = parameters.as_chunks::<PER_VIEW>().0;
        for ((mount, camera), own) in mounts().iter().zip(cameras()).zip(rows) {
            let eye = |camera: &Camera| DVec3::from(camera.position().map(f64::from));
            let up = |camera: &Camera| {
                let m = camera.camera_to_world.map(f64::from);
                DVec3::new(m[1], m[5], m[9])
            };
            let found = mount.camera(&camera, own);
            assert!(eye(&found).distance(eye(&camera) + place(eye(&camera))) < 1e-4);
            assert!(up(&found).distance(rotation * up(&camera)) < 1e-5);
        }
        Gauge::new(&mounts()).fix(&mut parameters);
        assert!(parameters.iter().all(|v| v.abs() < 1e-8), "{parameters:?}");
    }

    #[test]
    fn what_is_left_has_nothing_in_common() {
        let gauge = Gauge::new(&mounts());
        assert_eq!(gauge.0.len(), 7);
        let mut random = Random::new(1, [0; 3]);
        let before: Vec<f32> = (0..24).map(|_| normal(&mut random)).collect();
        let mut fixed = before.clone();
        gauge.fix(&mut fixed);
        let mut again = fixed.clone();
        gauge.fix(&mut again);
        let same = again.iter().zip(&fixed).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(same, "nothing is left to be taken out");
        // The nearest: what is taken out is at right angles to what is left.
        let along: f32 = fixed.iter().zip(&before).map(|(left, all)| left * (all - left)).sum();
        assert!(along.abs() < 1e-5, "{along}");
        // One camera has nothing but what it has in common with itself.
        let mut alone = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        Gauge::new(&mounts()[..1]).fix(&mut alone);
        assert!(alone.iter().all(|v| v.abs() < 1e-6), "{alone:?}");
    }
}
