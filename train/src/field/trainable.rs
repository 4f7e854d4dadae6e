//! What training asks of a field, whatever its kind.
//!
//! A field never sees a ray. Forwards, the step marches through core's view of it; on the
//! way back it hands over batches of samples, and a field adds up its own gradients.

use std::fmt::Debug;

use fearless_simd::Level;
use pocketnerf_core::march::Hierarchical;
use pocketnerf_core::scratch::Tuning;
use pocketnerf_core::{AnyField, Error};

use rayon::prelude::*;

use super::layout::Layout;
use crate::stopwatch::Stopwatch;
use crate::trainer::Adam;

/// Samples or rays of a batch at most.
pub const BATCH: usize = 2048;
/// Values between two rows of a batch.
pub const STRIDE: usize = Tuning { samples: BATCH, rays: 1 }.stride();
/// Rays whose samples a hierarchical pass evaluates together: few enough that what all
/// layers gave for their 768 samples, 8 MB, is still in the third-level cache on the way
/// back.
pub const HIERARCHICAL_RAYS: usize = 4;

/// A field in training: its shape, what it derives from its parameters, and buffers.
pub trait TrainableField: Debug + Send + Sync {
    /// Where each tensor lies among the parameters.
    fn layout(&self) -> &Layout;

    /// Fills `parameters` with the values that training starts from.
    fn initialize(&self, seed: u64, parameters: &mut [f32]);

    /// The field that reads `parameters`.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    fn view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error>;

    /// The field as training evaluates it, perhaps of rounded parameters.
    ///
    /// # Errors
    /// As [`view`](Self::view).
    fn training_view<'a>(&'a self, parameters: &'a [f32]) -> Result<AnyField<'a>, Error> {
        self.view(parameters)
    }

    /// Takes over parameters that are set all at once.
    fn set(&mut self, level: Level, parameters: &[f32]);

    /// Takes over the parameters of the next step, which has so many groups of rays.
    fn prepare(&mut self, parameters: &[f32], groups: usize);

    /// The way back for a group of rays. Gradients are summed in the order of the groups,
    /// whichever thread comes first.
    fn back<'a>(&'a self, group: usize, context: Context<'a>) -> Box<dyn Back + 'a>;

    /// From now on the forward pass reads the parameters themselves: rounding would hide
    /// the differences by which tests find gradients.
    #[cfg(test)]
    fn set_exact(&mut self) {}

    /// The sum of the groups' gradients by these parameters, laid out as they are.
    #[cfg(test)]
    fn gradient(&self, level: Level, parameters: &[f32]) -> Vec<f32>;

    /// Changes the parameters as the groups' gradients say.
    fn update(&mut self, update: Update<'_>);

    /// From now on each table is rounded to multiples of a step of about this length, as they
    /// are in a model of few bytes.
    fn round_coarsely(&mut self, _: Level, _lengths: &[f32], _parameters: &[f32]) {}

    /// What a checkpoint holds of how tables are rounded: a byte a table, and one more where
    /// they are rounded coarsely.
    fn scales(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes back [`scales`](Self::scales), after [`set`](Self::set); false for bytes that
    /// it never gives.
    fn restore_scales(&mut self, _: Level, _: &[u8], _: &[f32]) -> bool {
        true
    }
}

/// What a group's way back may use.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// How to compute.
    pub level: Level,
    /// The parameters of the step.
    pub parameters: &'a [f32],
    /// Where the time of each stage is recorded.
    pub stopwatch: Option<&'a Stopwatch>,
}

/// A group's way back through a field: one thread's.
pub trait Back {
    /// Deferred shading: the colours of `n` rays, a multiple of 32, from their mean
    /// features and their directions. Rows are [`STRIDE`] values apart. Kinds whose samples
    /// have their own colours need none.
    fn colors(&mut self, _features: &[f32], _directions: [&[f32]; 3], _n: usize) -> &[f32] {
        &[]
    }

    /// From the gradient of these colours to that of the features.
    fn colors_back(&mut self, _d_colors: &[f32], _n: usize) -> &[f32] {
        &[]
    }

    /// From the gradient of samples to that of the parameters.
    fn samples(&mut self, samples: &SampleGradients<'_>);

    /// From the gradient of the samples that were handed over last to that of their unit
    /// coordinates, with the share of each level of a grid in it. Kinds that never have theirs
    /// asked for give none.
    fn points(&mut self, _levels: &[f32], _d_points: [&mut [f32]; 3]) {}

    /// Evaluations that are kept for the way back, where the kind has them.
    fn tape(&mut self) -> Option<&mut dyn Tape> {
        None
    }
}

/// A batch of samples with their gradients.
#[derive(Clone, Copy, Debug)]
pub struct SampleGradients<'s> {
    /// Samples; slices are zero from there to a multiple of 32.
    pub len: usize,
    /// Unit coordinates.
    pub points: [&'s [f32]; 3],
    /// Unit directions, where samples have their own colours.
    pub directions: [&'s [f32]; 3],
    /// Density of each.
    pub sigma: &'s [f32],
    /// Colour of each, where samples have their own.
    pub colors: [&'s [f32]; 3],
    /// `[sample][row_len]`: gradients of the logarithm of the density, then of the
    /// channels.
    pub gradients: &'s [f32],
    /// Values of a row.
    pub row_len: usize,
}

/// Which of the networks of hierarchical sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Network {
    /// The one that decides where samples lie.
    Coarse,
    /// The one that is rendered.
    Fine,
}

/// Evaluations of samples, kept until their gradients are known: hierarchical sampling.
/// There is one batch a network.
pub trait Tape {
    /// Evaluates a network at unit `points` along `directions`, whole blocks of 32.
    fn forward(&mut self, network: Network, points: [&[f32]; 3], directions: [&[f32]; 3]);

    /// The samples' densities before their activation.
    fn raw(&mut self, network: Network) -> &mut [f32];

    /// The samples' densities.
    fn densities(&mut self, network: Network, sigma: &mut Vec<f32>);

    /// A sample's colour.
    fn color(&self, network: Network, sample: usize) -> [f32; 3];

    /// Replaces a sample's evaluation by the gradients of its density and colour.
    fn set_gradient(
        &mut self,
        network: Network,
        sample: usize,
        sigma: f32,
        d_sigma: f32,
        d_color: [f32; 3],
    );

    /// From the gradients of the first `len` samples, which are all set, to those of the
    /// parameters.
    fn back(&mut self, network: Network, len: usize);
}

/// How parameters change.
#[derive(Debug)]
pub struct Update<'u> {
    /// How to compute.
    pub level: Level,
    /// The parameters.
    pub parameters: &'u mut [f32],
    /// First moments of all but tables.
    pub mean: &'u mut [f32],
    /// Second moments.
    pub square: &'u mut [f32],
    /// Steps taken, this one included.
    pub step: u32,
    /// Constants of Adam.
    pub adam: Adam,
    /// Learning rate of tables.
    pub table_rate: f32,
    /// Decay of table entries where there is a gradient, times the learning rate.
    pub table_decay: f32,
    /// Share of the way to the mean of their neighbours that table entries go where there is a
    /// gradient, times the learning rate.
    pub table_smoothing: f32,
    /// Learning rate of all else.
    pub rate: f32,
    /// Where the time of each stage is recorded.
    pub stopwatch: Option<&'u Stopwatch>,
}

/// Adds the groups' gradients to a sum, each value's in the order of the groups.
pub(super) fn sum_groups(sum: &mut [f32], groups: &[&[f32]]) {
    /// Values of a task.
    const TASK: usize = 1 << 14;
    sum.par_chunks_mut(TASK).enumerate().for_each(|(part, sums)| {
        for group in groups {
            let own = group[part * TASK..].iter();
            sums.iter_mut().zip(own).for_each(|(sum, g)| *sum += g);
        }
    });
}

/// Training by hierarchical sampling (Mildenhall et al. 2020, section 5.3): rays from all
/// pixels, stratified and hierarchical samples, the error of both networks, and none of
/// this program's own methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchicalTraining {
    /// How many samples.
    pub sampling: Hierarchical,
    /// Standard deviation of what is added to the network's density at random.
    pub noise: f32,
    /// In so many first steps rays come from the middle halves of the images.
    pub crop_steps: u32,
}
