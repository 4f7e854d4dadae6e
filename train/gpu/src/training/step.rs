//! What a step is asked for, and what it gives.

use std::time::Duration;

use pocketnerf_core::{Occupancy, Ray};

/// A ray and the pixel that it is to look like.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Through its centre.
    pub ray: Ray,
    /// Where in its step each sample lies, 0 to 1.
    pub phase: f32,
    /// How much its error counts.
    pub weight: f32,
    /// Whether it is the middle one of a row of three pixels, whose others come after it.
    pub begins_row: bool,
    /// Mean of what may be behind the scene, and the variance of its channels.
    pub background: [f32; 3],
    /// See `background`.
    pub background_variance: f32,
    /// Its colour over that background.
    pub target: [f32; 3],
    /// Its opacity.
    pub alpha: f32,
}

/// A pixel's sixteen numbers, as the shader has them.
pub type PixelNumbers = [[f32; 4]; 4];

impl Pixel {
    /// As the shader has it.
    #[must_use]
    pub fn numbers(&self) -> PixelNumbers {
        let [ox, oy, oz] = self.ray.origin;
        let [dx, dy, dz] = self.ray.direction;
        let ([br, bg, bb], [r, g, b]) = (self.background, self.target);
        let weight = if self.begins_row { -self.weight } else { self.weight };
        [
            [ox, oy, oz, self.phase],
            [dx, dy, dz, weight],
            [br, bg, bb, self.background_variance],
            [r, g, b, self.alpha],
        ]
    }
}

/// How tables follow their gradients: Adam without momentum.
#[derive(Clone, Copy, Debug)]
pub struct TableRates {
    /// Learning rate, corrected.
    pub rate: f32,
    /// What a step leaves of an entry that has a gradient.
    pub kept: f32,
    /// Part of the squared gradient that is new.
    pub new: f32,
    /// Keeps the division finite.
    pub epsilon: f32,
}

/// How the networks follow their gradient.
#[derive(Clone, Copy, Debug)]
pub struct NetworkRates {
    /// Learning rate of matrices by Muon; `None`: Adam leads them, too.
    pub muon: Option<f32>,
    /// Learning rate of what Adam leads, corrected.
    pub adam: f32,
    /// Parts of the gradient and of its square that are new.
    pub new: [f32; 2],
}

/// What a step depends on beside the rays.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'s> {
    /// Cells to march through.
    pub occupancy: Occupancy<'s>,
    /// Distance between samples.
    pub step: f32,
    /// A ray ends where less light than this passes, and counts as opaque.
    pub min_transmittance: f32,
    /// Where less light passes, samples stand for several steps.
    pub coarse_step_below: f32,
    /// Gradients at least this large are always passed back. 0: all are.
    pub roulette: f32,
    /// How tables follow.
    pub tables: TableRates,
    /// How the networks follow.
    pub networks: NetworkRates,
    /// Samples nearer to their camera than this learn less, unit lengths. 0: none does.
    pub slow_below: f32,
    /// Weight of smooth surfaces. 0: they may be rough.
    pub smooth_surfaces: f32,
    /// Where random numbers begin.
    pub seed: u32,
    /// The number of the step.
    pub number: u32,
    /// Whether directions are blurred between the cameras.
    pub blur_directions: bool,
    /// Whether colours between the cameras are held to what these see.
    pub between_views: bool,
    /// Whether the parameters after the step count in their average.
    pub average: bool,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayResult {
    /// Squared error of its colour, a channel.
    pub squared_error: f32,
    /// Opacity.
    pub opacity: f32,
    /// Sum of its samples' gradient magnitudes.
    pub gradient_size: f32,
    /// Samples.
    pub samples: u32,
    /// Samples that were passed back.
    pub kept: u32,
}

impl RayResult {
    pub(super) fn of(bytes: &[u8; 16]) -> Self {
        let number = |i: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[4 * i + byte]));
        let [squared_error, opacity, gradient_size] = [0, 1, 2].map(number);
        let counts = number(3).to_bits();
        let (samples, kept) = (counts & 0xffff, counts >> 16);
        Self { squared_error, opacity, gradient_size, samples, kept }
    }
}

/// What a step gives.
#[derive(Clone, Debug, Default)]
pub struct StepResult {
    /// Of each ray; empty where there was not enough room for their samples. Then nothing was learnt,
    /// and the next step has more.
    pub rays: Vec<RayResult>,
    /// Whether all parameters are finite.
    pub is_finite: bool,
    /// How long each kernel took, in their order; empty where nobody asked.
    pub times: Vec<(&'static str, Duration)>,
}

/// All that is learnt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Learnt {
    /// Entries of the tables, level after level; then weights and bias of each layer, the density
    /// network first.
    pub parameters: Vec<f32>,
    /// First moments of the networks' parameters.
    pub mean: Vec<f32>,
    /// Second moments.
    pub square: Vec<f32>,
    /// Sums over the steps that count in the average; empty before the first.
    pub sum: Vec<f32>,
    /// Exponent of the unit that each level is rounded to multiples of, and units of a step.
    pub scales: Vec<[i32; 2]>,
}
