//! Backwards: from rays to samples to networks and encoded points.

use std::mem::take;

use fearless_simd::Simd;
use pocketnerf_core::encoding::hash_grid;
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::lanes::transpose;
use pocketnerf_core::march::LANES;

use super::group::{BATCH, Group, Job, Kept, STRIDE, Worker, row_len};
use crate::stopwatch::{Laps, Stage};

impl Group {
    /// From rays to samples, back to front: the derivative of the volume
    /// rendering sum. Small gradients are dropped at random and the rest
    /// enlarged, so that the expected sum is the same.
    #[inline(always)]
    pub(crate) fn sample_gradients(&mut self, job: &Job<'_>, row_len: usize) {
        let Self { records, values, sums, ray_gradients, suffix, kept, stats, random, .. } = self;
        let mut laps = Laps::begin(job.stopwatch);
        suffix.clear();
        suffix.resize(ray_gradients.len(), 0.0);
        kept.clear();
        let mut random = random.take().expect("set with the rays");
        for (s, record) in records.iter().enumerate().rev() {
            let r = record.ray as usize;
            let values = &values[record.row as usize * row_len..][..row_len];
            let along = dot(&sums[r * row_len..][..row_len], values);
            let d_weight = ray_gradients[r].opacity + along;
            let step = job.step * record.steps;
            let d_sigma = step * (record.transmittance * d_weight - suffix[r]);
            suffix[r] += record.weight * d_weight;
            let log_density = d_sigma * values[0];
            let size = log_density.abs() + record.weight * ray_gradients[r].size;
            stats.gradient_size += f64::from(size);
            let mut enlarge = 1.0;
            if size < job.roulette {
                if random.next_f32() * job.roulette >= size {
                    continue;
                }
                enlarge = job.roulette / size;
            }
            kept.push(Kept {
                sample: s as u32,
                log_density: log_density * enlarge,
                weight: record.weight * enlarge,
            });
        }
        stats.kept = kept.len();
        laps.end(Stage::Shade, 0);
    }

    /// From samples to network weights and encoded points.
    #[inline(always)]
    pub(crate) fn back_through_networks<S: Simd>(
        &mut self,
        simd: S,
        field: &HashGridField<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let mut laps = Laps::begin(job.stopwatch);
        let decoder = &field.decoder;
        let row_len = row_len(decoder.channels());
        let n_encoded = field.n_encoded();
        let block_size = (3 + n_encoded) * STRIDE;
        // Taken out, so that the rest of the group can be borrowed beside them.
        let (all_kept, mut blocks) = (take(&mut self.kept), take(&mut self.blocks));
        self.block_lens.clear();
        let n_blocks = all_kept.len().div_ceil(BATCH);
        if blocks.len() < n_blocks * block_size {
            blocks.resize(n_blocks * block_size, 0.0);
        }
        for (kept, block) in all_kept.chunks(BATCH).zip(blocks.chunks_mut(block_size)) {
            let padded = kept.len().next_multiple_of(32);
            self.block_lens.push(padded);
            let (points, d_encoded) = block.split_at_mut(3 * STRIDE);
            let axes = points.as_chunks_mut::<STRIDE>().0;
            for (column, k) in kept.iter().enumerate() {
                for (row, p) in axes.iter_mut().zip(self.records[k.sample as usize].point) {
                    row[column] = p;
                }
            }
            for row in &mut *axes {
                row[kept.len()..padded].fill(0.0);
            }
            let points = [0, 1, 2].map(|axis| &axes[axis][..padded]);
            hash_grid::encode(simd, &field.grid, points, &mut worker.a, STRIDE);
            laps.end(Stage::EncodeAgain, kept.len());
            let d_values = &mut worker.d_values[..padded * row_len];
            d_values[kept.len() * row_len..].fill(0.0);
            for (k, row) in kept.iter().zip(d_values.chunks_exact_mut(row_len)) {
                let r = self.records[k.sample as usize].ray as usize;
                let d_sums = &self.sums[r * row_len..][..row_len];
                for (value, d) in row.iter_mut().zip(d_sums) {
                    *value = k.weight * d;
                }
                row[0] = k.log_density;
            }
            let rows = worker.gradients.rows();
            for (to, part) in rows.chunks_mut(LANES * STRIDE).zip((0..row_len).step_by(LANES)) {
                for at in (0..padded).step_by(LANES) {
                    let from = &d_values[at * row_len + part..];
                    transpose(simd, (from, row_len, LANES), (&mut to[at..], STRIDE), LANES);
                }
            }
            if decoder.shading == Shading::PerSample {
                self.back_through_color(simd, decoder, job, worker, kept);
            } else {
                let Worker { a, gradients, .. } = &mut *worker;
                job.backward.density_forward(simd, decoder, a, gradients, padded, None);
            }
            let wanted = (n_encoded > 0).then_some(&mut *d_encoded);
            let weights = &mut self.network_gradient;
            job.backward.density(simd, &worker.a, &mut worker.gradients, padded, weights, wanted);
            laps.end(Stage::Backward, kept.len());
        }
        (self.kept, self.blocks) = (all_kept, blocks);
    }

    /// Per-sample shading: from the gradient of each sample's colour (rows 1
    /// to 3 of the gradient) to that of its features, with the encoded points in
    /// `worker.a`.
    #[inline(always)]
    fn back_through_color<S: Simd>(
        &mut self,
        simd: S,
        decoder: &Decoder<'_>,
        job: &Job<'_>,
        worker: &mut Worker,
        kept: &[Kept],
    ) {
        let n_features = decoder.n_features as usize * STRIDE;
        let padded = kept.len().next_multiple_of(32);
        for row in &mut worker.directions {
            row[kept.len()..padded].fill(0.0);
        }
        for (column, k) in kept.iter().enumerate() {
            let r = self.records[k.sample as usize].ray as usize;
            for (row, d) in worker.directions.iter_mut().zip(self.rays[r].ray.direction) {
                row[column] = d;
            }
        }
        {
            let Worker { a, gradients, output, color_input, .. } = &mut *worker;
            let values = Some(&mut output[..]);
            job.backward.density_forward(simd, decoder, a, gradients, padded, values);
            color_input[..n_features].copy_from_slice(&output[STRIDE..STRIDE + n_features]);
        }
        worker.colors(simd, decoder, job.backward, padded);
        let rows = worker.gradients.rows();
        for c in 0..3 {
            for column in 0..padded {
                let rgb = worker.output[c * STRIDE + column];
                rows[c * STRIDE + column] = rows[(1 + c) * STRIDE + column] * rgb * (1.0 - rgb);
            }
        }
        let Worker { color_input, d_color_input, gradients, .. } = &mut *worker;
        let weights = &mut self.network_gradient;
        job.backward.color(simd, color_input, gradients, padded, weights, d_color_input);
        let rows = gradients.rows();
        for (value, k) in rows.iter_mut().zip(kept) {
            *value = k.log_density;
        }
        rows[kept.len()..padded].fill(0.0);
        rows[STRIDE..STRIDE + n_features].copy_from_slice(&d_color_input[..n_features]);
    }
}

/// Sum of products of two rows.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    // In pairs: a fixed order, and short chains.
    let mut n = LANES;
    while n > 1 {
        n /= 2;
        for i in 0..n {
            sums[i] += sums[i + n];
        }
    }
    sums[0]
}
