//! The paper's field in occupied cells: marched through as any field, and back.

use fearless_simd::Simd;
use pocketnerf_core::field::NerfField;

use super::group::{Group, GroupStats, Job, Worker, row_len};
use super::worker::NERF_BATCH;
use crate::field::slope;
use crate::stopwatch::{Laps, Stage};

impl Group {
    /// Everything: march, compare, and back.
    #[inline(always)]
    pub(crate) fn run_nerf<S: Simd>(
        &mut self,
        simd: S,
        field: &NerfField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        self.stats = GroupStats::default();
        self.network_gradient.fill(0.0);
        if let Some(paper) = &job.paper {
            self.run_paper(simd, field, job, paper, worker);
            return;
        }
        self.march(simd, field, job, worker);
        self.compare(row_len(3));
        self.sample_gradients(job, row_len(3));
        let mut laps = Laps::begin(job.stopwatch);
        self.back_through_nerf(simd, field, job, worker);
        laps.end(Stage::Backward, self.kept.len());
    }

    /// From samples to weights: forwards again, everything kept, then backwards.
    #[inline(always)]
    fn back_through_nerf<S: Simd>(
        &mut self,
        simd: S,
        field: &NerfField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let Worker { points, directions, nerf, .. } = worker;
        let (Some(nerf), Some(gradients)) = (nerf, job.backward.nerf()) else { return };
        let row_len = row_len(3);
        for kept in self.kept.chunks(NERF_BATCH) {
            let padded = kept.len().next_multiple_of(32);
            for row in points.iter_mut().chain(&mut *directions) {
                row[kept.len()..padded].fill(0.0);
            }
            for (column, k) in kept.iter().enumerate() {
                let record = &self.records[k.sample as usize];
                let direction = self.rays[record.ray as usize].ray.direction;
                for axis in 0..3 {
                    points[axis][column] = record.point[axis];
                    directions[axis][column] = direction[axis];
                }
            }
            let points = [0, 1, 2].map(|axis| &points[axis][..padded]);
            let directions = [0, 1, 2].map(|axis| &directions[axis][..padded]);
            let tape = &mut nerf.tapes[0];
            tape.forward(simd, field, points, directions);
            for (s, k) in kept.iter().enumerate() {
                let record = &self.records[k.sample as usize];
                let sigma = self.values[record.row as usize * row_len];
                let d_colors = &self.sums[record.ray as usize * row_len + 1..][..3];
                // What is kept has a density: without one, nothing goes back.
                let d_sigma = k.log_density / sigma;
                let slope = slope(field.activation, sigma / field.density_scale);
                let d_raw = if sigma > 0.0 { d_sigma * field.density_scale * slope } else { 0.0 };
                tape.set_gradient(s, d_raw, [0, 1, 2].map(|c| k.weight * d_colors[c]));
            }
            tape.clear_from(kept.len());
            let to = &mut self.network_gradient;
            gradients.backward(simd, false, tape, &mut nerf.work, to);
        }
    }
}
