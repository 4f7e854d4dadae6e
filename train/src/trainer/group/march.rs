//! Forwards: from rays to samples to what each ray gathers.

use fearless_simd::Simd;
use pocketnerf_core::composite::{self, Gathered};
use pocketnerf_core::field::{Field, Samples, Shading};
use pocketnerf_core::lanes::transpose;
use pocketnerf_core::sampler::{Bundle, LANES};
use pocketnerf_core::scratch::Workspace;
use pocketnerf_core::store::Store;

use super::{BATCH, Group, Job, MIN_TRANSMITTANCE, RUN, Record, STRIDE, Worker, row_len};
use crate::stopwatch::{Laps, Stage};

impl Group {
    /// Density and features along every ray until it is opaque.
    #[inline(always)]
    pub(super) fn march<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let mut laps = Laps::begin(job.stopwatch);
        let per_sample = field.decoder().shading == Shading::PerSample;
        let row_len = row_len(field.decoder());
        self.records.clear();
        self.values.clear();
        self.sums.clear();
        self.sums.resize(self.rays.len() * row_len, 0.0);
        self.gathered.clear();
        self.gathered.resize(self.rays.len(), Gathered::NOTHING);
        self.bundles.clear();
        self.passed.clear();
        self.passed.resize(self.rays.len().div_ceil(LANES), [1.0; LANES]);
        for rays in self.rays.chunks(LANES) {
            let mut bundle = Bundle::EMPTY;
            for (lane, r) in rays.iter().enumerate() {
                bundle.set(lane, &r.ray, r.phase);
            }
            job.marcher.enter(simd, &mut bundle);
            (rays.len()..LANES).for_each(|lane| bundle.stop(lane));
            self.bundles.push(bundle);
        }
        loop {
            let n = self.gather(simd, job, per_sample, worker);
            laps.end(Stage::March, n);
            if n == 0 {
                return;
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
            field.encode(simd, samples.points, work.a, STRIDE);
            laps.end(Stage::Encode, n);
            field.decoder().density_features::<S, T>(simd, samples, &mut work);
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

    /// Fills a batch with the next samples of the living rays; gives their number.
    #[inline(always)]
    fn gather<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        per_sample: bool,
        worker: &mut Worker,
    ) -> usize {
        let alive: usize = self.bundles.iter().map(Bundle::alive).sum();
        let most = (BATCH / alive.max(1)).clamp(*RUN.start(), *RUN.end());
        let Worker { points: [x, y, z], directions, owners, steps, .. } = worker;
        let mut n = 0;
        for (number, bundle) in self.bundles.iter_mut().enumerate() {
            // Every lane may take all it is allowed.
            let room = most.min((BATCH - n) / LANES);
            if room == 0 {
                break;
            }
            let start = n;
            let transmittance = |lane: usize| {
                self.gathered.get(number * LANES + lane).map_or(0.0, |g| g.transmittance)
            };
            let transmittance = std::array::from_fn(transmittance);
            let most = composite::samples_needed(
                &transmittance,
                &self.passed[number],
                MIN_TRANSMITTANCE,
                room,
            );
            let lengths = transmittance.map(|passes| composite::steps(passes, job.late));
            job.marcher.advance(simd, bundle, [&most, &lengths], &mut |found| {
                for lane in found.lanes() {
                    [x[n], y[n], z[n]] = [0, 1, 2].map(|a| found.u[a][lane]);
                    owners[n] = (number * LANES + lane) as u32;
                    steps[n] = lengths[lane];
                    n += 1;
                }
            });
            if per_sample {
                for (row, d) in directions.iter_mut().zip(&bundle.direction) {
                    for (value, owner) in row[start..n].iter_mut().zip(&owners[start..n]) {
                        *value = d[*owner as usize % LANES];
                    }
                }
            }
        }
        n
    }

    /// Adds a batch to its rays and records what going back will need. The
    /// batch's values begin at row `first`.
    #[inline(always)]
    fn composite(&mut self, worker: &Worker, n: usize, first: usize, row_len: usize) {
        for s in 0..n {
            let ray = worker.owners[s];
            let gathered = &mut self.gathered[ray as usize];
            if gathered.transmittance < MIN_TRANSMITTANCE {
                // It has become opaque within this batch.
                continue;
            }
            let weight = gathered.add(worker.a[s], 0.0);
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
                transmittance: gathered.transmittance,
            });
            self.passed[ray as usize / LANES][ray as usize % LANES] = 1.0 - worker.a[s];
            if gathered.transmittance < MIN_TRANSMITTANCE {
                self.bundles[ray as usize / LANES].stop(ray as usize % LANES);
            }
        }
    }
}
