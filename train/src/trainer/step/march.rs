//! Forwards: from rays to samples to what each ray gathers.

use std::ops::Range;

use fearless_simd::Simd;
use pocketnerf_core::Space;
use pocketnerf_core::field::{Field, Samples};
use pocketnerf_core::lanes::transpose;
use pocketnerf_core::march::composite::{self, Accumulated};
use pocketnerf_core::march::{LANES, RayPacket, RayQueue, RayState, SampleBatch};
use pocketnerf_core::scratch::Workspace;

use super::group::{BATCH, Group, Job, MIN_TRANSMITTANCE, Record, STRIDE, Worker, row_len};
use crate::aligned::Aligned;
use crate::stopwatch::{Laps, Stage};

impl Group {
    /// Density and features along every ray until it is opaque.
    #[inline(always)]
    pub(crate) fn march<S: Simd, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let mut laps = Laps::begin(job.stopwatch);
        let per_sample = field.deferred().is_none();
        let row_len = row_len(field.channels());
        self.records.clear();
        self.values.clear();
        self.sums.clear();
        self.sums.resize(self.rays.len() * row_len, 0.0);
        self.accumulated.clear();
        self.accumulated.resize(self.rays.len(), Accumulated::EMPTY);
        self.last_transmittance.clear();
        self.last_transmittance.resize(self.rays.len(), 1.0);
        self.walks.clear();
        for rays in self.rays.chunks(LANES) {
            let mut packet = RayPacket::EMPTY;
            for (lane, r) in rays.iter().enumerate() {
                packet.set(lane, &r.ray, r.phase);
            }
            job.marcher.enter(simd, &mut packet);
            self.walks.extend((0..rays.len()).map(|lane| packet.state(lane)));
        }
        self.active.clear();
        self.active.extend((0..self.rays.len()).map(|ray| ray as f32));
        loop {
            let n = self.gather(simd, job, per_sample, worker);
            laps.end(Stage::March, n);
            if self.active.is_empty() {
                return;
            }
            if n == 0 {
                // Rays have been seeking.
                continue;
            }
            self.stats.samples += n;
            let padded = n.next_multiple_of(32);
            for row in worker.points.iter_mut().chain(&mut worker.directions) {
                row[n..padded].fill(0.0);
            }
            let Worker { a, b, output, panel, points, directions, .. } = &mut *worker;
            let mut work = Workspace { a, b, output, panel, stride: STRIDE };
            let samples = Samples {
                points: [0, 1, 2].map(|axis| &points[axis][..padded]),
                directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
            };
            field.encode(simd, samples.points, &mut work);
            laps.end(Stage::Encode, n);
            field.decode(simd, samples, &mut work);
            laps.end(Stage::Density, n);
            // The first row of `a` is free now: opacities go there, sigma stays.
            worker.a[..padded].copy_from_slice(&worker.output[..padded]);
            for (sigma, steps) in worker.a.iter_mut().zip(&worker.steps[..n]) {
                *sigma *= steps;
            }
            composite::opacities(simd, &mut worker.a[..padded], job.step);
            let first = self.values.len();
            self.values.resize(first + padded * row_len, 0.0);
            let values = &mut self.values[first..];
            for (from, part) in
                worker.output.chunks(LANES * STRIDE).zip((0..row_len).step_by(LANES))
            {
                transpose(simd, (from, STRIDE, LANES), (&mut values[part..], row_len), padded);
            }
            self.composite(worker, n, first / row_len, row_len);
            laps.end(Stage::Composite, n);
        }
    }

    /// Fills a batch with the next samples of the active rays; gives their number.
    #[inline(always)]
    fn gather<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        per_sample: bool,
        worker: &mut Worker,
    ) -> usize {
        let Self { walks, active, accumulated, last_transmittance, .. } = self;
        let Worker { points: [x, y, z], t, directions, owners, steps, .. } = worker;
        let rows = [x, y, z, t].map(|row| &mut row[..BATCH]);
        let mut batch = SampleBatch { rows, len: 0 };
        let directions = per_sample.then_some(directions);
        let (late, space) = (job.late, job.marcher.space());
        let mut rays =
            Rays { walks, accumulated, last_transmittance, owners, steps, directions, late, space };
        let alive = job.marcher.gather(simd, &mut rays, active, &mut batch);
        active.truncate(alive);
        batch.len
    }

    /// Adds a batch to its rays and records what going back will need. The
    /// batch's values begin at row `first`.
    #[inline(always)]
    fn composite(&mut self, worker: &Worker, n: usize, first: usize, row_len: usize) {
        for s in 0..n {
            let ray = worker.owners[s];
            let accumulated = &mut self.accumulated[ray as usize];
            if accumulated.transmittance < MIN_TRANSMITTANCE {
                // It has become opaque within this batch.
                continue;
            }
            let weight = accumulated.add(worker.a[s], 0.0);
            let sums = &mut self.sums[ray as usize * row_len..][..row_len];
            let values = &self.values[(first + s) * row_len..][..row_len];
            let pairs = sums.as_chunks_mut::<LANES>().0.iter_mut();
            for (sums, values) in pairs.zip(values.as_chunks::<LANES>().0) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
            self.records.push(Record {
                point: [worker.points[0][s], worker.points[1][s], worker.points[2][s]],
                ray,
                row: (first + s) as u32,
                weight,
                steps: worker.steps[s],
                transmittance: accumulated.transmittance,
            });
            self.last_transmittance[ray as usize] = 1.0 - worker.a[s];
            if accumulated.transmittance < MIN_TRANSMITTANCE {
                self.walks[ray as usize].stop();
            }
        }
    }
}

/// A group's rays, and what is written down of a batch's samples.
struct Rays<'g> {
    walks: &'g mut [RayState],
    accumulated: &'g [Accumulated],
    last_transmittance: &'g [f32],
    owners: &'g mut [u32],
    steps: &'g mut [f32],
    /// Where samples want directions.
    directions: Option<&'g mut [Aligned<f32>; 3]>,
    late: f32,
    space: &'g Space,
}

impl RayQueue for Rays<'_> {
    #[inline(always)]
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        let transmittance = self.accumulated[ray].transmittance;
        let [needed] = composite::samples_needed(
            &[transmittance],
            &[self.last_transmittance[ray]],
            MIN_TRANSMITTANCE,
            room,
        );
        self.walks[ray].steps = composite::steps(transmittance, self.late);
        (self.walks[ray], needed as usize)
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, walk: &RayState, samples: Range<usize>) {
        self.walks[ray] = *walk;
        self.owners[samples.clone()].fill(ray as u32);
        self.steps[samples.clone()].fill(walk.steps);
        if let Some(rows) = &mut self.directions {
            for (row, d) in rows.iter_mut().zip(walk.public_direction(self.space)) {
                row[samples.clone()].fill(d);
            }
        }
    }

    #[inline(always)]
    fn skip_to(&mut self, ray: usize, next: f32) {
        self.walks[ray].next = next;
    }
}
