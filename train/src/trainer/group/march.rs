//! Forwards: from rays to samples to what each ray gathers.

use fearless_simd::Simd;
use pocketnerf_core::composite::{self, Gathered};
use pocketnerf_core::field::{Field, Samples, Shading};
use pocketnerf_core::scratch::Workspace;
use pocketnerf_core::store::Store;

use super::transpose::{LANES, transpose};
use super::{
    BATCH, Group, Job, MIN_TRANSMITTANCE, RUN, Record, STRIDE, Traveller, Worker, row_len,
};

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
        let per_sample = field.decoder().shading == Shading::PerSample;
        let row_len = row_len(field.decoder());
        self.records.clear();
        self.values.clear();
        self.sums.clear();
        self.sums.resize(self.rays.len() * row_len, 0.0);
        self.travellers.clear();
        self.travellers.extend(self.rays.iter().map(|r| Traveller {
            path: job.marcher.path(r.ray, r.phase),
            gathered: Gathered::NOTHING,
            run: 0,
        }));
        self.alive.clear();
        self.alive.extend(0..self.rays.len() as u32);
        loop {
            self.alive.retain(|r| self.travellers[*r as usize].path.is_alive());
            let n = self.gather(job, per_sample, worker);
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
            field.density_features::<S, T>(simd, samples, &mut work);
            // The first row of `a` is free now: opacities go there, sigma stays.
            worker.a[..padded].copy_from_slice(&worker.output[..padded]);
            composite::opacities(simd, &mut worker.a[..padded], job.step);
            let first = self.values.len();
            self.values.resize(first + padded * row_len, 0.0);
            let values = &mut self.values[first..];
            for (from, part) in
                worker.output.chunks(LANES * STRIDE).zip((0..row_len).step_by(LANES))
            {
                transpose(simd, from, STRIDE, &mut values[part..], row_len, padded);
            }
            self.composite(worker, first / row_len, row_len);
        }
    }

    /// Fills a batch with the next samples of the living rays; gives their number.
    #[inline(always)]
    fn gather(&mut self, job: &Job<'_>, per_sample: bool, worker: &mut Worker) -> usize {
        let most = (BATCH / self.alive.len().max(1)).clamp(*RUN.start(), *RUN.end());
        let [x, y, z] = &mut worker.points;
        let mut n = 0;
        for r in &self.alive {
            let traveller = &mut self.travellers[*r as usize];
            let start = n;
            let room = most.min(BATCH - n);
            if room > 0 {
                job.marcher.advance(&mut traveller.path, room, |_, u| {
                    [x[n], y[n], z[n]] = u;
                    n += 1;
                });
            }
            if per_sample {
                for (row, d) in worker.directions.iter_mut().zip(traveller.path.ray.direction) {
                    row[start..n].fill(d);
                }
            }
            traveller.run = n - start;
        }
        n
    }

    /// Adds a batch to its rays and records what going back will need. The
    /// batch's values begin at row `first`.
    #[inline(always)]
    fn composite(&mut self, worker: &Worker, first: usize, row_len: usize) {
        let mut start = 0;
        for r in &self.alive {
            let traveller = &mut self.travellers[*r as usize];
            let sums = &mut self.sums[*r as usize * row_len..][..row_len];
            let run = start..start + traveller.run;
            start = run.end;
            for s in run {
                let weight = traveller.gathered.add(worker.a[s], 0.0);
                let values = &self.values[(first + s) * row_len..][..row_len];
                let pairs = sums.as_chunks_mut::<LANES>().0.iter_mut();
                for (sums, values) in pairs.zip(values.as_chunks::<LANES>().0) {
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += weight * value;
                    }
                }
                self.records.push(Record {
                    point: [worker.points[0][s], worker.points[1][s], worker.points[2][s]],
                    ray: *r,
                    row: (first + s) as u32,
                    weight,
                    transmittance: traveller.gathered.transmittance,
                });
                if traveller.gathered.transmittance < MIN_TRANSMITTANCE {
                    traveller.path.next = traveller.path.end;
                    break;
                }
            }
        }
    }
}
