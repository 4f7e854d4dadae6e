//! A fixed share of a step's rays, forwards and backwards.
//!
//! A step is cut into the same groups at any thread count, and every group
//! adds up its own gradients, so that the sums never depend on who worked when.

use fearless_simd::Simd;
use pocketnerf_core::Space;
use pocketnerf_core::field::{Field, HashGridField, Shading};
use pocketnerf_core::march::composite::Accumulated;
use pocketnerf_core::march::{LANES, Marcher, RayState};
use pocketnerf_core::scratch::Tuning;

pub(crate) use super::worker::Worker;
use crate::field::Backward;
use crate::random::Random;
use crate::stopwatch::Stopwatch;
use crate::trainer::config::Paper;
use crate::trainer::pixels::importance::Attention;
use crate::trainer::pixels::rays::{Pixel, RaySource, TrainingRay};
use crate::trainer::pixels::visibility::Aim;

/// Samples a batch; rows lie [`STRIDE`] values apart.
pub(super) const BATCH: usize = 2048;
/// Distance between the rows of a batch.
pub(crate) const STRIDE: usize = Tuning { samples: BATCH, rays: 1 }.stride();
/// A ray ends in training where its transmittance falls below this, and counts
/// as opaque.
pub(crate) const MIN_TRANSMITTANCE: f32 = 2e-2;

/// What all groups of a step share.
#[derive(Debug)]
pub(crate) struct Job<'j> {
    pub(crate) marcher: Marcher<'j>,
    pub(crate) backward: &'j Backward,
    /// Distance between samples, scene units.
    pub(crate) step: f32,
    /// Where less light than this passes, samples stand for several steps.
    pub(crate) coarse_step_below: f32,
    /// Gradients at least this large are always kept; smaller ones in
    /// proportion to their size, and enlarged accordingly. 0: all are kept.
    pub(crate) roulette: f32,
    /// The paper's sampling, in place of marching.
    pub(crate) paper: Option<Paper>,
    /// Where rays enter and leave.
    pub(crate) space: Space,
    /// How near and how far.
    pub(crate) reach: [f32; 2],
    /// Where the time of each stage is written down.
    pub(crate) stopwatch: Option<&'j Stopwatch>,
}

/// What the backward pass needs of a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    /// Unit coordinates.
    pub(crate) point: [f32; 3],
    pub(super) ray: u32,
    /// Row of `values`.
    pub(super) row: u32,
    pub(super) weight: f32,
    /// Steps that it stands for.
    pub(crate) steps: f32,
    /// Light that passes the sample.
    pub(crate) transmittance: f32,
}

/// The gradient that a ray hands to its samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RayGradient {
    /// Of the opacity.
    pub(super) opacity: f32,
    /// Sum of the magnitudes of the channels' gradients.
    pub(super) size: f32,
}

/// A sample whose gradient goes on to the network.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    pub(super) sample: u32,
    /// Gradient of the log density.
    pub(super) log_density: f32,
    /// Weight of the ray's channel gradients.
    pub(super) weight: f32,
}

/// What a group found out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupStats {
    /// Sum of squared errors over rays and colours, weighed.
    pub(crate) squared_error: f64,
    /// Sum of opacities over rays, weighed.
    pub(crate) opacity: f64,
    /// Samples at which the field was asked.
    pub(crate) samples: usize,
    /// Samples that were passed back.
    pub(crate) kept: usize,
    /// Sum of the samples' gradient magnitudes.
    pub(crate) gradient_size: f64,
}

/// A group's buffers, kept from step to step.
#[derive(Debug, Default)]
pub(crate) struct Group {
    pub(super) pixels: Vec<Pixel>,
    /// Where each was drawn from, and what it weighs.
    pub(super) drawn: Vec<(u32, f32)>,
    pub(super) colors: Vec<[u8; 4]>,
    pub(super) rays: Vec<TrainingRay>,
    /// Squared error of each ray, a channel.
    pub(super) errors: Vec<f32>,
    pub(super) random: Option<Random>,
    /// The rays on their way.
    pub(super) states: Vec<RayState>,
    /// Numbers of those that have steps left.
    pub(super) active: Vec<u32>,
    /// What each ray has accumulated.
    pub(super) accumulated: Vec<Accumulated>,
    /// Part of the light that passes each ray's last sample.
    pub(super) last_transmittance: Vec<f32>,
    /// `[ray][row_len]`: what each ray accumulated of the values; later its
    /// gradient, with 0 in sigma's place.
    pub(super) sums: Vec<f32>,
    pub(super) ray_gradients: Vec<RayGradient>,
    pub(super) records: Vec<Record>,
    /// `[sample][row_len]`: sigma, then the channels.
    pub(super) values: Vec<f32>,
    pub(super) suffix: Vec<f32>,
    pub(super) kept: Vec<Kept>,
    /// Blocks of `[3 + n_encoded][STRIDE]`: points and gradients for the scatter.
    pub(crate) blocks: Vec<f32>,
    /// Points in each block, a multiple of 32.
    pub(crate) block_lens: Vec<usize>,
    /// Gradient of the networks' parameters.
    pub(crate) network_gradient: Vec<f32>,
    pub(crate) stats: GroupStats,
}

/// Values between two rows of one sample or ray each: sigma and the channels,
/// rounded up to whole registers.
pub(super) const fn row_len(channels: usize) -> usize {
    (1 + channels).next_multiple_of(LANES)
}

impl Group {
    /// A group for networks with so many parameters.
    pub(crate) fn new(n_network: usize) -> Self {
        Self { network_gradient: vec![0.0; n_network], ..Self::default() }
    }

    /// Draws `n` rays from the stream of this place.
    pub(crate) fn draw(
        &mut self,
        source: &RaySource,
        (aim, attention): (&Aim, &Attention),
        n: usize,
        mut random: Random,
    ) {
        // In rounds: tiles and pixels lie anywhere in memory, and the processor fetches
        // many at a time where it has nothing else to do.
        self.drawn.clear();
        self.drawn.extend((0..n).map(|_| attention.draw(&mut random)));
        self.pixels.clear();
        let tiles = self.drawn.iter().map(|(tile, _)| *tile as usize);
        self.pixels.extend(tiles.map(|tile| aim.pixel(source.cameras(), tile, &mut random)));
        self.colors.clear();
        self.colors.extend(self.pixels.iter().map(|pixel| source.rgba(*pixel)));
        self.rays.clear();
        let pixels = self.pixels.iter().zip(&self.colors).zip(&self.drawn);
        self.rays.extend(
            pixels.map(|((pixel, rgba), drawn)| source.ray(*pixel, *rgba, *drawn, &mut random)),
        );
        self.errors.clear();
        self.errors.resize(n, 0.0);
        self.random = Some(random);
    }

    /// The tile that each ray came from, and its squared error a channel.
    pub(crate) fn errors(&self) -> impl Iterator<Item = (u32, f32)> {
        self.rays.iter().map(|ray| ray.tile).zip(self.errors.iter().copied())
    }

    /// The same rays with other luck in the roulette.
    #[cfg(test)]
    pub(crate) fn reseed(&mut self, random: Random) {
        self.random = Some(random);
    }

    /// Rays that ended before they left the box.
    #[cfg(test)]
    pub(crate) fn ended(&self) -> usize {
        self.accumulated.iter().filter(|ray| ray.transmittance < MIN_TRANSMITTANCE).count()
    }

    /// The rays that were run last, each with its samples.
    #[cfg(test)]
    pub(crate) fn rays_with_samples(&self) -> impl Iterator<Item = (TrainingRay, Vec<Record>)> {
        self.rays.iter().enumerate().map(|(r, ray)| {
            let own = self.records.iter().filter(move |record| record.ray as usize == r);
            (*ray, own.copied().collect())
        })
    }

    /// Everything: march, shade, and both backward passes.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &mut self,
        simd: S,
        field: &HashGridField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        self.stats = GroupStats::default();
        self.network_gradient.fill(0.0);
        self.march(simd, field, job, worker);
        match field.decoder.shading {
            Shading::PerRay => self.shade(simd, field, job, worker),
            Shading::PerSample => self.compare(row_len(field.channels())),
        }
        self.sample_gradients(job, row_len(field.channels()));
        self.back_through_networks(simd, field, job, worker);
    }
}
