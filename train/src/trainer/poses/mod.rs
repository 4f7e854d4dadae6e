//! Poses of the photographs, corrected while the field learns (Lin et al. 2021, "BARF").
//!
//! Each photograph has six numbers: how its camera turns, a rotation vector in radians, and how it
//! moves, in mean distances of the cameras ([`Mount`]). What they learn from are the gradients of
//! the samples' positions and of the rays' directions.

mod gauge;

use pocketnerf_core::encoding::hash_grid::MAX_LEVELS;
use pocketnerf_core::{Camera, Space};

use super::Adam;
use super::parameters::{GroupSections, ParameterGroup};
use super::run::checkpoint::kind;
use crate::cameras::mount::Mount;
pub(crate) use crate::cameras::mount::PER_VIEW;
use gauge::Gauge;

/// Learning rate at its highest: radians, and shares of the cameras' distance.
const RATE: f32 = 5e-4;
/// What remains of it at the end.
const FINAL_RATE: f32 = 0.02;
/// Share of the run over which it rises: at first there is fog, which says nothing of poses.
const WARM_UP: f32 = 0.02;
/// Share of the run after which all levels of a grid count: the finer a level, the nearer poses
/// have to be before its gradient points towards the right ones.
const DETAILED: f32 = 0.5;
/// The constants of Adam.
const ADAM: Adam = Adam { beta1: 0.9, beta2: 0.99, epsilon: 1e-15, decay: 0.0 };

/// Cameras as the dataset has them, and what their corrections are measured by.
#[derive(Clone, Debug)]
pub(crate) struct Poses {
    given: Vec<Camera>,
    mounts: Vec<Mount>,
    /// Length of a shift of 1, scene units.
    unit: f32,
    gauge: Gauge,
    /// Levels of the field's grid.
    n_levels: usize,
}

/// How poses are corrected in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseStep<'s> {
    poses: &'s Poses,
    rate: f32,
    /// How much the gradient through each level of a grid counts.
    pub(crate) levels: [f32; MAX_LEVELS],
}

impl Poses {
    /// Of these cameras, for a field of so many levels; `None` where there are no cameras.
    pub(crate) fn new(cameras: &[Camera], space: &Space, n_levels: usize) -> Option<Self> {
        let center = space.center();
        let ahead = |camera: &Camera| match space {
            // Half of what lies between the near plane and infinity, as those coordinates see it.
            Space::Ndc(ndc) => 2.0 * ndc.near,
            _ => {
                let eye = camera.position();
                (0..3).map(|a| (eye[a] - center[a]).powi(2)).sum::<f32>().sqrt()
            }
        };
        let unit = cameras.iter().map(ahead).sum::<f32>() / cameras.len() as f32;
        let mount = |camera| Mount::new(camera, ahead(camera), unit);
        let mounts: Vec<Mount> = cameras.iter().map(mount).collect();
        let gauge = Gauge::new(&mounts);
        let given = cameras.to_vec();
        let sound = unit.is_finite() && unit > 0.0;
        sound.then_some(Self { given, mounts, unit, gauge, n_levels })
    }

    /// The parameters of no correction.
    pub(crate) fn group(&self) -> ParameterGroup {
        let sections = GroupSections {
            parameters: Some(kind::POSES),
            mean: kind::POSE_MEAN,
            square: kind::POSE_SQUARE,
            sum: kind::POSE_SUM,
        };
        ParameterGroup::of_views(PER_VIEW * self.given.len(), ADAM, sections)
    }

    /// The step of a run after this share of it.
    pub(crate) fn step(&self, progress: f32) -> PoseStep<'_> {
        let open = 1.0 + (self.n_levels as f32 - 1.0) * (progress / DETAILED).min(1.0);
        let rate = RATE * (progress / WARM_UP).min(1.0) * FINAL_RATE.powf(progress);
        let levels = core::array::from_fn(|level| {
            let share = (open - level as f32).clamp(0.0, 1.0);
            0.5 - 0.5 * (core::f32::consts::PI * share).cos()
        });
        PoseStep { poses: self, rate, levels }
    }

    /// The cameras with these corrections.
    pub(crate) fn cameras(&self, parameters: &[f32]) -> Vec<Camera> {
        let corrections = parameters.as_chunks::<PER_VIEW>().0;
        let cameras = self.given.iter().zip(&self.mounts).zip(corrections);
        cameras.map(|((given, mount), own)| mount.camera(given, own)).collect()
    }

    /// By how much each camera is turned, degrees, and moved, shares of the cameras' distance.
    pub(crate) fn sizes(&self, parameters: &[f32]) -> Vec<[f32; 2]> {
        let corrections = parameters.as_chunks::<PER_VIEW>().0;
        let sizes = self.mounts.iter().zip(corrections).map(|(mount, own)| mount.size(own));
        sizes.map(|[turn, shift]| [turn.to_degrees() as f32, shift as f32 / self.unit]).collect()
    }

    /// From the pull on a view's camera to the gradient of its correction.
    pub(crate) fn gradient(&self, view: usize, own: &[f32; 6], pull: &[f32; 6]) -> [f32; 6] {
        self.mounts[view].gradient(own, pull)
    }
}

impl PoseStep<'_> {
    /// New corrections, from the sum of each camera's pulls: the force on it, and the torque about
    /// it. `number` counts steps from 1.
    pub(crate) fn update(&self, group: &mut ParameterGroup, pulls: &[[f32; 6]], number: u32) {
        let Self { poses, rate, .. } = *self;
        let rate = group.adam.corrected(rate, number);
        let ParameterGroup { parameters, mean, square, adam, .. } = group;
        let rows = parameters.as_chunks::<PER_VIEW>().0.iter().zip(pulls).enumerate();
        let gradient: Vec<_> =
            rows.map(|(view, (own, pull))| poses.gradient(view, own, pull)).collect();
        adam.follow(rate, gradient.as_flattened(), [&mut parameters[..], mean, square]);
        poses.gauge.fix(parameters);
    }
}
