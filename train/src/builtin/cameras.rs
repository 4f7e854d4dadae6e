//! Where the built-in scenes are seen from.

use super::{HELD_OUT_VIEWS, SIZE, TRAIN_VIEWS};
use core::f32::consts::TAU;
use pocketnerf_core::{Camera, math};

/// Angle between a training view and the next, seen from the origin, radians.
/// The turns of the spiral lie 15° apart.
const STEP: f32 = 0.44;
/// The angle that spreads any number of points evenly around an axis, in turns.
const GOLDEN_ANGLE: f64 = 0.381_966_011_250_105;

/// Places around the origin, which all cameras look at, or past.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    /// Distance of the first and of the last view from the origin, scene units.
    pub(super) distances: [f32; 2],
    /// What the distance may be multiplied with: cameras stay outside of solids.
    factors: [f32; 2],
    /// Sine of the elevation of the first and of the last view.
    sines: [f32; 2],
    /// How far behind the origin the point lies that a camera looks at, level with it.
    past: f32,
    /// Horizontal field of view in radians.
    pub(super) fov_x: f32,
}

/// Around an object, from −9° to 75°; the field of view of the Blender NeRF scenes.
pub(super) const AROUND: Region = Region {
    distances: [4.0; 2],
    factors: [0.4, 100.0],
    sines: [-0.16, 0.966],
    past: 0.0,
    fov_x: 0.691_111_2,
};
/// Across the middle of a room, from −17° to 30°, with a wide lens.
pub(super) const INSIDE: Region = Region {
    distances: [0.95; 2],
    factors: [0.5, 1.2],
    sines: [-0.3, 0.5],
    past: 0.0,
    fov_x: 1.25,
};
/// Around an object outdoors, from −3° to 33° and ever closer, past it at the horizon.
pub(super) const OUTDOORS: Region = Region {
    distances: [4.0, 2.5],
    factors: [0.5, 1.1],
    sines: [-0.05, 0.55],
    past: 1.5,
    fov_x: 1.1,
};

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
        let factor = distance_factor.clamp(self.factors[0], self.factors[1]);
        let view = |i: usize| {
            let turns = i as f64 * GOLDEN_ANGLE;
            let azimuth = (turns - turns.floor()) as f32 * TAU;
            self.camera([i as f32 + 0.5, n as f32], azimuth, factor)
        };
        (0..n).map(view).collect()
    }

    /// Points on the spiral, two for each training view. Sines of elevation are
    /// evenly spaced, so that every view has an equal share of the sphere.
    fn spiral(&self) -> impl Iterator<Item = Camera> {
        let mut azimuth = 0.0;
        (0..2 * TRAIN_VIEWS).map(move |k| {
            let place = [k as f32, (2 * TRAIN_VIEWS - 1) as f32];
            let view = self.camera(place, azimuth, 1.0);
            azimuth += 0.5 * STEP / self.elevation(place)[0];
            view
        })
    }

    /// Cosine and sine of the elevation at place `i` of `n` from the lowest to the highest.
    fn elevation(&self, place: [f32; 2]) -> [f32; 2] {
        let sine = between(self.sines, place);
        [math::sqrt(1.0 - sine * sine), sine]
    }

    fn camera(&self, place: [f32; 2], azimuth: f32, distance_factor: f32) -> Camera {
        let [cosine, sine] = self.elevation(place);
        let (s, c) = math::sin_cos(azimuth);
        let distance = between(self.distances, place) * distance_factor;
        let eye = [cosine * c, cosine * s, sine].map(|x| x * distance);
        let target = [-self.past * c, -self.past * s, 0.0];
        let pose = Camera::look_at(eye, target, [0.0, 0.0, 1.0]);
        Camera::from_fov_x(SIZE, SIZE, self.fov_x, pose)
    }
}

/// From `low` to `high`, at place `i` of `n`.
fn between([low, high]: [f32; 2], [i, n]: [f32; 2]) -> f32 {
    low + (high - low) * i / n
}
