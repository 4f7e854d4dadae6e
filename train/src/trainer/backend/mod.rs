//! The wall between training and the machine that computes it.
//!
//! A [`Trainer`](super::Trainer) decides which rays and which settings, and what follows
//! from a step; a backend holds the parameters and takes the steps. The processor's is
//! [`Cpu`]; with the cargo feature `gpu` there is a GPU's.

mod cpu;
#[cfg(feature = "gpu")]
mod drawing;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(all(test, feature = "gpu"))]
mod gpu_tests;
#[cfg(feature = "gpu")]
mod learner;
#[cfg(feature = "gpu")]
mod self_test;
#[cfg(feature = "gpu")]
mod settings;

use std::fmt::Debug;
use std::time::Duration;

use pocketnerf_core::{AnyField, Occupancy, Sampling, SimdLevel, Space};

pub(crate) use cpu::Cpu;
#[cfg(feature = "gpu")]
pub(crate) use gpu::OnGpu;

use super::DensityGrid;
use super::gains::GainStep;
use super::parameters::State;
use super::pixels::importance::PixelSampler;
use super::pixels::rays::RaySource;
use super::pixels::visibility::PixelVisibility;
use super::poses::PoseStep;
use crate::field::HierarchicalTraining;
use crate::stopwatch::Stopwatch;

/// What computes the steps of a run.
pub(crate) trait Backend: Debug + Send + Sync {
    /// Forgets all that is learnt: parameters are what training starts from.
    fn reset(&mut self, seed: u64);

    /// Takes over all that is learnt.
    fn upload(&mut self, state: State);

    /// All that is learnt, after the last step.
    fn download(&self) -> &State;

    /// The field's parameters alone, after the last step.
    fn parameters(&self) -> &[f32] {
        &self.download().field().parameters
    }

    /// Takes a step. What it gives may be what an earlier one found out, or nothing: a device may
    /// have steps under way.
    fn step(&mut self, input: &StepInput<'_>) -> StepOutput;

    /// Waits for the steps that are under way, and gives what the last one found out.
    fn wait(&mut self) -> StepOutput {
        StepOutput::default()
    }

    /// Looks at a share of a grid's cells: the field's densities at random points of them.
    fn densities(&self, grid: &mut DensityGrid, seed: u64);

    /// Whether rays skip what is empty by core's table of cells.
    fn skips_by_table(&self) -> bool {
        true
    }

    /// Whether all parameters are finite; with or without the tables.
    fn is_finite(&self, tables: bool) -> bool;

    /// From now on each table is rounded to multiples of a step of about this length.
    fn round_coarsely(&mut self, lengths: &[f32]);

    /// The field of the parameters.
    fn field(&self) -> AnyField<'_>;

    /// How pictures are rendered for tests of the finished model.
    fn simd(&self) -> SimdLevel;

    /// From now on rays are those that the CPU would draw.
    #[cfg(all(test, feature = "gpu"))]
    fn draw_like_the_cpu(&mut self) {}

    /// As if the device were lost.
    #[cfg(all(test, feature = "gpu"))]
    fn lose(&mut self) {}

    /// How long each kernel of a GPU has taken since steps are timed.
    fn kernels(&self) -> Vec<(&'static str, Duration)> {
        Vec::new()
    }

    /// Why the CPU takes the steps that another device was to take; `None` where that does.
    fn fallback(&self) -> Option<String> {
        None
    }
}

/// All that a step depends on, beside what the backend holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepInput<'s> {
    /// Pixels to learn from, which of them see something, and how often each is drawn.
    pub(crate) source: &'s RaySource,
    pub(crate) visibility: &'s PixelVisibility,
    pub(crate) sampler: &'s PixelSampler,
    /// Rays.
    pub(crate) n_rays: usize,
    /// Where random numbers begin.
    pub(crate) seed: u64,
    /// Steps taken before.
    pub(crate) step: u32,
    /// Coordinates of the scene.
    pub(crate) space: Space,
    /// Cells to march through.
    pub(crate) occupancy: Occupancy<'s>,
    /// Distance of samples and limits of rays.
    pub(crate) sampling: Sampling,
    /// Where less light than this passes, samples stand for several steps.
    pub(crate) coarse_step_below: f32,
    /// Hierarchical sampling in place of marching.
    pub(crate) hierarchical: Option<HierarchicalTraining>,
    /// Gradients at least this large are always passed back; smaller ones in proportion
    /// to their size, and enlarged accordingly. 0: all are.
    pub(crate) roulette: f32,
    /// Learning rate of tables.
    pub(crate) table_rate: f32,
    /// Part of a table's entry that is taken away where there is a gradient, times the
    /// learning rate.
    pub(crate) table_decay: f32,
    /// Share of the way to the mean of their neighbours that table entries go where there is a
    /// gradient, times the learning rate.
    pub(crate) table_smoothing: f32,
    /// Learning rate of all else.
    pub(crate) rate: f32,
    /// Whether the parameters after the step count in their average.
    pub(crate) average: bool,
    /// Weight of smooth surfaces; 0: they may be rough.
    pub(crate) smooth_surfaces: f32,
    /// Width of what rays of a pixel go through, pixels; 0: its centre alone.
    pub(crate) spread: f32,
    /// Whether colours between the training views are held to what these see.
    pub(crate) between_views: bool,
    /// Whether directions are blurred: there are few views.
    pub(crate) blur_directions: bool,
    /// How gains are learnt, where photographs are evened out.
    pub(crate) gains: Option<GainStep<'s>>,
    /// How poses are corrected, where they are.
    pub(crate) poses: Option<PoseStep<'s>>,
    /// Where the time of each stage is recorded.
    pub(crate) stopwatch: Option<&'s Stopwatch>,
}

/// What a step found out.
#[derive(Clone, Debug, Default)]
pub(crate) struct StepOutput {
    /// Rays of the step; none where it found nothing out.
    pub(crate) rays: usize,
    /// Gradients at least this large were passed back.
    pub(crate) roulette: f32,
    /// Sum of squared errors over rays and colours, weighed.
    pub(crate) squared_error: f64,
    /// Sum of opacities over rays, weighed.
    pub(crate) opacity: f64,
    /// Samples at which the field was evaluated.
    pub(crate) samples: usize,
    /// Samples that were passed back.
    pub(crate) kept: usize,
    /// Sum of the samples' gradient magnitudes.
    pub(crate) gradient_size: f64,
    /// The tile that each ray came from, and its squared error a channel.
    pub(crate) errors: Vec<(u32, f32)>,
}
