//! A fixed share of a step's rays, forwards and backwards.
//!
//! A step is cut into the same groups at any thread count, and every group
//! adds up its own gradients, so that sums do not depend on the threads.

use fearless_simd::{Level, dispatch};
use pocketnerf_core::march::composite::Accumulated;
use pocketnerf_core::march::{LANES, Marcher, RayState};
use pocketnerf_core::{AnyField, Camera, Space};

use super::poses::{PoseJob, Pull};
use super::slow_below::SlowBelow;
pub(crate) use super::worker::Worker;
pub(super) use crate::field::{BATCH, STRIDE};
use crate::field::{Back, HierarchicalTraining};
use crate::random::Random;
use crate::stopwatch::Stopwatch;
use crate::trainer::backend::StepInput;
use crate::trainer::loss::{TERMS, Term};
use crate::trainer::pixels::rays::{Pixel, RaySource, TrainingRay};

/// A ray ends in training where its transmittance falls below this, and counts
/// as opaque.
pub(crate) const MIN_TRANSMITTANCE: f32 = 2e-2;

/// What all groups of a step share.
#[derive(Debug)]
pub(crate) struct Job<'j> {
    pub(crate) marcher: Marcher<'j>,
    /// Distance between samples, scene units.
    pub(crate) step: f32,
    /// Where less light than this passes, samples stand for several steps.
    pub(crate) coarse_step_below: f32,
    /// Gradients at least this large are always kept; smaller ones in
    /// proportion to their size, and enlarged accordingly. 0: all are kept.
    pub(crate) roulette: f32,
    /// Hierarchical sampling in place of marching.
    pub(crate) hierarchical: Option<HierarchicalTraining>,
    /// Where rays enter and leave.
    pub(crate) space: Space,
    /// How near and how far.
    pub(crate) reach: [f32; 2],
    /// Terms of the loss beside the squared error.
    pub(crate) terms: &'j [&'j dyn Term],
    /// Cameras between which colours are held to what these see, where they are.
    pub(crate) cameras: Option<&'j [Camera]>,
    /// Few cameras between which directions are blurred, where they are.
    pub(crate) few_cameras: Option<&'j [Camera]>,
    /// Weight of smooth surfaces.
    pub(crate) smooth_surfaces: f32,
    /// Samples nearer than this to their camera learn less.
    pub(crate) slow_below: Option<SlowBelow>,
    /// Views before this number are photographs.
    pub(crate) n_photographs: u32,
    /// Photographs whose brightness is learnt; 0 where it is not.
    pub(crate) evened_out: usize,
    /// How poses are corrected, where they are.
    pub(crate) poses: Option<PoseJob>,
    /// Where the time of each stage is recorded.
    pub(crate) stopwatch: Option<&'j Stopwatch>,
}

impl<'j> Job<'j> {
    pub(crate) fn new(input: &StepInput<'j>) -> Self {
        let StepInput { occupancy, space, sampling, .. } = *input;
        Self {
            marcher: Marcher::from_parts(Some(occupancy), space, sampling, true),
            step: sampling.step,
            coarse_step_below: input.coarse_step_below,
            roulette: input.roulette,
            hierarchical: input.hierarchical,
            space,
            reach: [sampling.near, sampling.far],
            terms: TERMS,
            cameras: input.between_views.then(|| input.source.cameras()),
            few_cameras: input.blur_directions.then(|| input.source.cameras()),
            smooth_surfaces: input.smooth_surfaces,
            slow_below: SlowBelow::new(&space, input.source.nearest()),
            n_photographs: input.source.photographs().len() as u32,
            evened_out: input.gains.map_or(0, |gains| gains.given.len()),
            poses: input
                .poses
                .map(|poses| PoseJob { levels: poses.levels, views: input.source.cameras().len() }),
            stopwatch: input.stopwatch,
        }
    }

    /// Whether a term needs the rays' depths.
    pub(super) fn needs_depth(&self) -> bool {
        self.smooth_surfaces > 0.0 || self.terms.iter().any(|term| term.needs_depth())
    }
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
    /// Of the depth.
    pub(super) depth: f32,
    /// Sum of the magnitudes of the channels' gradients.
    pub(super) size: f32,
}

/// A sample whose gradient is passed back.
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
    /// Samples at which the field was evaluated.
    pub(crate) samples: usize,
    /// Samples that were passed back.
    pub(crate) kept: usize,
    /// Sum of the samples' gradient magnitudes.
    pub(crate) gradient_size: f64,
}

/// A group's buffers, kept from step to step.
#[derive(Debug, Default)]
pub(crate) struct Group {
    pub(crate) pixels: Vec<Pixel>,
    /// First of three rays each, which go through neighbouring pixels: the middle one, and both
    /// sides of it.
    pub(crate) rows: Vec<u32>,
    /// Where each was drawn from, and what it weighs.
    pub(super) drawn: Vec<(u32, f32)>,
    pub(super) colors: Vec<[u8; 4]>,
    pub(crate) rays: Vec<TrainingRay>,
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
    /// Distance of each record; empty where no term of the loss needs it.
    pub(super) distances: Vec<f32>,
    /// `[sample][row_len]`: sigma, then the channels.
    pub(super) values: Vec<f32>,
    pub(super) suffix: Vec<f32>,
    pub(super) kept: Vec<Kept>,
    /// The pull on each camera, where poses are corrected.
    pub(crate) pulls: Vec<Pull>,
    /// The gradient of each photograph's brightness, where that is learnt.
    pub(crate) d_gains: Vec<[f32; 3]>,
    pub(crate) stats: GroupStats,
}

/// Values between two rows of one sample or ray each: sigma and the channels,
/// rounded up to whole registers.
pub(super) const fn row_len(channels: usize) -> usize {
    (1 + channels).next_multiple_of(LANES)
}

impl Group {
    /// Draws `n` rays from the stream of this place.
    pub(crate) fn draw(&mut self, input: &StepInput<'_>, n: usize, mut random: Random) {
        let source = input.source;
        match &input.hierarchical {
            None => self.draw_weighed(input, n, &mut random),
            Some(training) => {
                let cropped = input.step < training.crop_steps;
                self.rays.clear();
                self.rays.extend((0..n).map(|_| source.draw_anywhere(cropped, &mut random)));
            }
        }
        self.errors.clear();
        self.errors.resize(n, 0.0);
        self.random = Some(random);
    }

    /// Draws rays where the error is.
    fn draw_weighed(&mut self, input: &StepInput<'_>, n: usize, random: &mut Random) {
        let StepInput { source, visibility, sampler, .. } = *input;
        // In rounds: tiles and pixels lie anywhere in memory, and the processor fetches
        // many at a time where it has nothing else to do.
        self.drawn.clear();
        self.drawn.extend((0..n).map(|_| sampler.draw(random)));
        self.pixels.clear();
        let tiles = self.drawn.iter().map(|(tile, _)| *tile as usize);
        self.pixels.extend(tiles.map(|tile| visibility.pixel(source.cameras(), tile, random)));
        self.draw_rows(input, random);
        self.colors.clear();
        self.colors.extend(self.pixels.iter().map(|pixel| source.rgba(*pixel)));
        self.rays.clear();
        let pixels = self.pixels.iter().zip(&self.colors).zip(&self.drawn);
        self.rays
            .extend(pixels.map(|((pixel, rgba), drawn)| source.ray(*pixel, *rgba, *drawn, random)));
        if input.spread > 0.0 {
            self.spread(source, input.spread, random);
        }
    }

    /// Sends each ray of a photograph through any point of the middle of its pixel, so many wide.
    fn spread(&mut self, source: &RaySource, width: f32, random: &mut Random) {
        let of_photographs = |(_, pixel): &(_, &Pixel)| source.is_photograph(pixel.view);
        for (ray, pixel) in self.rays.iter_mut().zip(&self.pixels).filter(of_photographs) {
            let mut off = || 0.5 + width * (random.next_f32() - 0.5);
            let at = [pixel.x as f32 + off(), pixel.y as f32 + off()];
            ray.ray = source.through_point(pixel.view, at);
        }
    }

    /// The tile that each ray came from, and its squared error a channel.
    pub(crate) fn errors(&self) -> impl Iterator<Item = (u32, f32)> {
        self.rays.iter().map(|ray| ray.tile).zip(self.errors.iter().copied())
    }

    /// The samples that at least this share of their rays' light reaches.
    pub(crate) fn lit(&self, least: f32) -> impl Iterator<Item = &Record> {
        self.records.iter().filter(move |record| record.transmittance + record.weight >= least)
    }

    /// The same rays with other luck in the roulette.
    #[cfg(test)]
    pub(crate) fn reseed(&mut self, random: Random) {
        self.random = Some(random);
    }

    /// The view that each ray is of.
    #[cfg(test)]
    pub(crate) fn views(&self) -> impl Iterator<Item = usize> {
        self.pixels.iter().map(|pixel| pixel.view as usize)
    }

    /// Rays that ended before they left the box.
    #[cfg(test)]
    pub(crate) fn ended(&self) -> usize {
        self.accumulated.iter().filter(|ray| ray.transmittance < MIN_TRANSMITTANCE).count()
    }

    /// The rays that were run last, each with its samples and, where a term of the loss
    /// needs them, their distances.
    #[cfg(test)]
    pub(crate) fn rays_with_samples(
        &self,
    ) -> impl Iterator<Item = (TrainingRay, Vec<(Record, f32)>)> {
        let distance = |s: usize| self.distances.get(s).copied().unwrap_or(0.0);
        self.rays.iter().enumerate().map(move |(r, ray)| {
            let own = self.records.iter().enumerate();
            let own = own.filter(|(_, record)| record.ray as usize == r);
            (*ray, own.map(|(s, record)| (*record, distance(s))).collect())
        })
    }

    /// Everything: march, shade, and both backward passes.
    pub(crate) fn run(
        &mut self,
        level: Level,
        field: &AnyField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
        back: &mut dyn Back,
    ) {
        self.stats = GroupStats::default();
        if let Some(training) = &job.hierarchical {
            if let Some(tape) = back.tape() {
                dispatch!(level, simd => self.run_hierarchical(simd, job, training, tape));
            }
            return;
        }
        self.d_gains.clear();
        self.d_gains.resize(job.evened_out, [0.0; 3]);
        if let Some(poses) = &job.poses {
            self.release_cameras(poses);
        }
        let (channels, deferred) = (field.channels(), field.deferred());
        dispatch!(level, simd => self.march(simd, field, job, worker));
        let row_len = row_len(channels);
        if let Some(decoder) = deferred {
            let shape = (channels, decoder.sh_degree);
            dispatch!(level, _simd => self.shade(shape, job, worker, back));
        } else {
            self.compare(job, row_len);
        }
        self.hold_smooth(job.smooth_surfaces, &job.space);
        dispatch!(level, _simd => self.sample_gradients(job, row_len));
        self.back_through_field((row_len, deferred.is_none()), job, worker, back);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::View;
    use crate::trainer::pixels::rays::Backdrop;

    #[test]
    fn rays_spread_over_their_pixels() {
        let pose = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(4, 4, 1.0, pose);
        let source = RaySource::new(vec![View::new("", camera, vec![255; 64])], Backdrop::Random);
        let mut random = Random::new(1, [0; 3]);
        let (pixel, n) = (Pixel { view: 0, x: 3, y: 1 }, 400);
        let rays = (0..n).map(|_| source.ray(pixel, [255; 4], (0, 1.0), &mut random)).collect();
        let mut group = Group { pixels: vec![pixel; n], rays, ..Group::default() };
        for width in [0.5, 1.0] {
            group.spread(&source, width, &mut random);
            let [mut least, mut most] = [[9.0f32; 2], [-9.0f32; 2]];
            for ray in &group.rays {
                let [x, y, z] = ray.ray.direction;
                let at = [2.0 - camera.focal[0] * x / z, 2.0 + camera.focal[1] * y / z];
                for (a, centre) in [3.5, 1.5].into_iter().enumerate() {
                    least[a] = least[a].min(at[a] - centre);
                    most[a] = most[a].max(at[a] - centre);
                }
            }
            for (least, most) in least.into_iter().zip(most) {
                assert!(-0.5 * width <= least + 1e-4 && least < -0.47 * width, "{width}: {least}");
                assert!(most <= 0.5 * width + 1e-4 && most > 0.47 * width, "{width}: {most}");
            }
        }
    }
}
