//! Forwards: from rays to samples to what each ray accumulates.

use std::mem::take;
use std::ops::Range;

use fearless_simd::Simd;
use pocketnerf_core::lanes::{LANES, transpose};
use pocketnerf_core::march::composite::{self, Accumulated, Lengths, opacities};
use pocketnerf_core::march::{
    self, Output, RayPacket, RayQueue, RayState, SampleBatch, SampleSink, march,
};
use pocketnerf_core::scratch::Workspace;
use pocketnerf_core::{AnyField, Ray};

use super::group::{BATCH, Group, Job, MIN_TRANSMITTANCE, Record, STRIDE, Worker, row_len};
use crate::stopwatch::{Laps, Stage};
use crate::trainer::pixels::rays::TrainingRay;

impl Group {
    /// Density and channels along every ray until it is opaque.
    #[inline(always)]
    pub(crate) fn march<S: Simd>(
        &mut self,
        simd: S,
        field: &AnyField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let laps = Laps::begin(job.stopwatch);
        let (n_rays, row_len) = (self.rays.len(), row_len(field.channels()));
        self.records.clear();
        self.distances.clear();
        self.values.clear();
        refill(&mut self.sums, n_rays * row_len, 0.0);
        refill(&mut self.accumulated, n_rays, Accumulated::EMPTY);
        refill(&mut self.last_transmittance, n_rays, 1.0);
        self.states.clear();
        for rays in self.rays.chunks(LANES) {
            let mut packet = RayPacket::EMPTY;
            for (lane, r) in rays.iter().enumerate() {
                packet.set(lane, &r.ray, r.phase);
            }
            job.marcher.enter(simd, &mut packet);
            self.states.extend((0..rays.len()).map(|lane| packet.state(lane)));
        }
        self.active.clear();
        self.active.extend(0..n_rays as u32);
        let mut active = take(&mut self.active);
        let Worker { a, b, output, panel, points, t, directions, owners, steps, .. } = worker;
        let [points, directions] =
            [points, directions].map(|rows| rows.each_mut().map(|r| &mut r[..]));
        let mut samples =
            SampleBatch { points, directions, t, capacity: BATCH, len: 0, directed: false };
        let mut work = Workspace { a, b, output, panel, stride: STRIDE, rounded: false };
        let needs_depth = job.needs_depth();
        let Self {
            rays,
            states,
            accumulated,
            last_transmittance,
            records,
            distances,
            values,
            sums,
            stats,
            ..
        } = self;
        let (coarse_step_below, step) = (job.coarse_step_below, job.step);
        let rays = TrainingRays {
            rays,
            states,
            accumulated,
            last_transmittance,
            owners,
            steps,
            coarse_step_below,
        };
        let n_samples = &mut stats.samples;
        let distances = needs_depth.then_some(distances);
        let mut sink =
            Recorder { rays, records, distances, values, sums, row_len, step, n_samples, laps };
        let batch = (&mut samples, &mut work);
        march(simd, field, Output::Channels, &job.marcher, batch, &mut active, &mut sink);
        self.active = active;
    }
}

fn refill<T: Clone>(values: &mut Vec<T>, n: usize, value: T) {
    values.clear();
    values.resize(n, value);
}

/// A group's rays, and what is noted of a batch's samples.
struct TrainingRays<'g> {
    rays: &'g [TrainingRay],
    states: &'g mut [RayState],
    accumulated: &'g mut [Accumulated],
    last_transmittance: &'g mut [f32],
    owners: &'g mut [u32],
    steps: &'g mut [f32],
    coarse_step_below: f32,
}

impl RayQueue for TrainingRays<'_> {
    #[inline(always)]
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        let transmittance = self.accumulated[ray].transmittance;
        let last = self.last_transmittance[ray];
        let needed = composite::samples_needed(transmittance, last, MIN_TRANSMITTANCE, room);
        self.states[ray].steps = composite::steps(transmittance, self.coarse_step_below);
        (self.states[ray], needed as usize)
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, state: &RayState, samples: Range<usize>) {
        self.states[ray] = *state;
        self.owners[samples.clone()].fill(ray as u32);
        self.steps[samples].fill(state.steps);
    }

    #[inline(always)]
    fn skip_to(&mut self, ray: usize, next: f32) {
        self.states[ray].next = next;
    }

    fn public(&self, ray: usize) -> Ray {
        self.rays[ray].ray
    }

    fn turn(&mut self, ray: usize, state: &RayState) {
        self.states[ray] = *state;
    }
}

/// Adds samples to their rays and records what going back will need.
struct Recorder<'g> {
    rays: TrainingRays<'g>,
    records: &'g mut Vec<Record>,
    /// Where a term of the loss needs them.
    distances: Option<&'g mut Vec<f32>>,
    /// `[sample][row_len]`.
    values: &'g mut Vec<f32>,
    /// `[ray][row_len]`.
    sums: &'g mut [f32],
    row_len: usize,
    /// Distance between samples.
    step: f32,
    n_samples: &'g mut usize,
    laps: Laps<'g>,
}

impl<'g> SampleSink for Recorder<'g> {
    type Queue = TrainingRays<'g>;

    #[inline(always)]
    fn queue(&mut self) -> &mut TrainingRays<'g> {
        &mut self.rays
    }

    #[inline(always)]
    fn accumulate<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleBatch<'_>,
        work: &mut Workspace<'_>,
    ) {
        *self.n_samples += samples.len;
        let padded = samples.len.next_multiple_of(LANES);
        // The first row of `a` is free now: opacities go there, sigma stays.
        let alpha = &mut work.a[..padded];
        alpha.copy_from_slice(&work.output[..padded]);
        opacities(simd, alpha, Lengths::Each(&self.rays.steps[..padded], self.step));
        let (first, row_len) = (self.values.len(), self.row_len);
        self.values.resize(first + padded * row_len, 0.0);
        let values = &mut self.values[first..];
        for (from, part) in work.output.chunks(LANES * STRIDE).zip((0..row_len).step_by(LANES)) {
            transpose(simd, (from, STRIDE, LANES), (&mut values[part..], row_len), padded);
        }
        self.composite(samples, alpha, first / row_len);
    }

    #[inline(always)]
    fn ended(&mut self, stage: march::Stage, n: usize) {
        self.laps.end(
            match stage {
                march::Stage::Encode => Stage::Encode,
                march::Stage::Density => Stage::Density,
                march::Stage::Composite => Stage::Composite,
                _ => Stage::March,
            },
            n,
        );
    }
}

impl Recorder<'_> {
    /// Adds a batch, whose values begin at row `first`, to its rays.
    #[inline(always)]
    fn composite(&mut self, samples: &SampleBatch<'_>, alpha: &[f32], first: usize) {
        let Self { rays, row_len, .. } = self;
        let row_len = *row_len;
        for (s, &alpha) in alpha.iter().enumerate().take(samples.len) {
            let ray = rays.owners[s];
            let accumulated = &mut rays.accumulated[ray as usize];
            if accumulated.transmittance < MIN_TRANSMITTANCE {
                // It has become opaque within this batch.
                continue;
            }
            let t = samples.t[s];
            if let Some(distances) = &mut self.distances {
                distances.push(t);
            }
            let weight = accumulated.add(alpha, t);
            let sums = &mut self.sums[ray as usize * row_len..][..row_len];
            let values = &self.values[(first + s) * row_len..][..row_len];
            let pairs = sums.as_chunks_mut::<LANES>().0.iter_mut();
            for (sums, values) in pairs.zip(values.as_chunks::<LANES>().0) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
            self.records.push(Record {
                point: [0, 1, 2].map(|axis| samples.points[axis][s]),
                ray,
                row: (first + s) as u32,
                weight,
                steps: rays.steps[s],
                transmittance: accumulated.transmittance,
            });
            rays.last_transmittance[ray as usize] = 1.0 - alpha;
            if accumulated.transmittance < MIN_TRANSMITTANCE {
                rays.states[ray as usize].stop();
            }
        }
    }
}
