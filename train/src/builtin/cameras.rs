//! Where the built-in scenes are seen from.

use super::{HELD_OUT_VIEWS, SIZE, TRAIN_VIEWS};
use core::f32::consts::TAU;
use pocketnerf_core::{Camera, math};

/// Angle between a training view and the next, seen from the origin, radians.
/// The turns of the spiral lie 15° apart.
const STEP: f32 = 0.44;
/// The angle that spreads any number of points evenly around an axis, in turns.
const GOLDEN_ANGLE: f64 = 0.381_966_011_250_105;

/// Places on a part of a sphere around the origin, which all cameras look at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    /// Distance of every camera from the origin, scene units.
    pub(super) distance: f32,
    /// What the distance may be multiplied with: cameras stay outside of solids.
    factors: [f32; 2],
    /// Sine of the elevation of the first and of the last view.
    sines: [f32; 2],
    /// Horizontal field of view in radians.
    pub(super) fov_x: f32,
}

/// Around an object, from −9° to 75°; the field of view of the Blender NeRF scenes.
pub(super) const AROUND: Region =
    Region { distance: 4.0, factors: [0.4, 100.0], sines: [-0.16, 0.966], fov_x: 0.691_111_2 };
/// Across the middle of a room, from −17° to 30°, with a wide lens.
pub(super) const INSIDE: Region =
    Region { distance: 0.95, factors: [0.5, 1.2], sines: [-0.3, 0.5], fov_x: 1.25 };

impl Region {
    /// The training views climb a spiral of five turns around the scene, so that
    /// view i + 1 is a neighbour of view i.
    pub(super) fn train(&self) -> Vec<Camera> {
        self.spiral().step_by(2).take(TRAIN_VIEWS).collect()
    }

    /// Held-out view j lies halfway between training views 5 j + 2 and 5 j + 3:
    /// on the spiral, as far from all training views as a point near it can be.
    pub(super) fn held_out(&self) -> Vec<Camera> {
        self.spiral().skip(5).step_by(10).take(HELD_OUT_VIEWS).collect()
    }

    /// Others, likewise between training views 5 j and 5 j + 1.
    pub(super) fn validation(&self) -> Vec<Camera> {
        self.spiral().skip(1).step_by(10).take(HELD_OUT_VIEWS).collect()
    }

    /// So many views, spread evenly over the region, the distance multiplied.
    pub(super) fn spread(&self, n: usize, distance_factor: f32) -> Vec<Camera> {
        let distance = self.distance * distance_factor.clamp(self.factors[0], self.factors[1]);
        let view = |i: usize| {
            let turns = i as f64 * GOLDEN_ANGLE;
            let azimuth = (turns - turns.floor()) as f32 * TAU;
            self.camera([i as f32 + 0.5, n as f32], azimuth, distance)
        };
        (0..n).map(view).collect()
    }

    /// Points on the spiral, two for each training view. Sines of elevation are
    /// evenly spaced, so that every view has an equal share of the sphere.
    fn spiral(&self) -> impl Iterator<Item = Camera> {
        let mut azimuth = 0.0;
        (0..2 * TRAIN_VIEWS).map(move |k| {
            let place = [k as f32, (2 * TRAIN_VIEWS - 1) as f32];
            let view = self.camera(place, azimuth, self.distance);
            azimuth += 0.5 * STEP / self.elevation(place)[0];
            view
        })
    }

    /// Cosine and sine of the elevation at place `i` of `n` from the lowest to the highest.
    fn elevation(&self, [i, n]: [f32; 2]) -> [f32; 2] {
        let [low, high] = self.sines;
        let sine = low + (high - low) * i / n;
        [math::sqrt(1.0 - sine * sine), sine]
    }

    fn camera(&self, place: [f32; 2], azimuth: f32, distance: f32) -> Camera {
        let [cosine, sine] = self.elevation(place);
        let (s, c) = math::sin_cos(azimuth);
        let eye = [cosine * c, cosine * s, sine].map(|x| x * distance);
        let pose = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]);
        Camera::from_fov_x(SIZE, SIZE, self.fov_x, pose)
    }
}
