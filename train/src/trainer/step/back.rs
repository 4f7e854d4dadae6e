//! Backwards: from rays to samples to the field's parameters.

use pocketnerf_core::march::LANES;

use super::group::{Group, Job, Kept, Worker};
use crate::field::{BATCH, Back, SampleGradients};
use crate::stopwatch::{Laps, Stage};

impl Group {
    /// From rays to samples, back to front: the derivative of the volume
    /// rendering sum. Small gradients are dropped at random and the rest
    /// enlarged, so that the expected sum is the same.
    #[inline(always)]
    pub(crate) fn sample_gradients(&mut self, job: &Job<'_>, row_len: usize) {
        let Self {
            rays,
            records,
            distances,
            values,
            sums,
            ray_gradients,
            suffix,
            kept,
            stats,
            random,
            ..
        } = self;
        let mut laps = Laps::begin(job.stopwatch);
        suffix.clear();
        suffix.resize(ray_gradients.len(), 0.0);
        kept.clear();
        let mut random = random.take().expect("set with the rays");
        for (s, record) in records.iter().enumerate().rev() {
            let r = record.ray as usize;
            let values = &values[record.row as usize * row_len..][..row_len];
            let along = dot(&sums[r * row_len..][..row_len], values);
            let mut d_weight = ray_gradients[r].opacity + along;
            if let Some(distance) = distances.get(s) {
                d_weight += ray_gradients[r].depth * distance;
            }
            let step = job.step * record.steps;
            let share = job.slow_below.map_or(1.0, |slow| slow.share(&rays[r].ray, record.point));
            let d_sigma = step * (record.transmittance * d_weight - suffix[r]);
            suffix[r] += record.weight * d_weight;
            let (log_density, weight) = (share * d_sigma * values[0], share * record.weight);
            let size = log_density.abs() + weight * ray_gradients[r].size;
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
                weight: weight * enlarge,
            });
        }
        stats.kept = kept.len();
        laps.end(Stage::Shade, 0);
    }

    /// From samples to the field's parameters, a batch at a time.
    pub(super) fn back_through_field(
        &mut self,
        (row_len, per_sample): (usize, bool),
        job: &Job<'_>,
        worker: &mut Worker,
        back: &mut dyn Back,
    ) {
        let all = std::mem::take(&mut self.kept);
        for kept in all.chunks(BATCH) {
            let padded = kept.len().next_multiple_of(32);
            let Worker { points, directions, sigma, colors, d_values, .. } = &mut *worker;
            for row in points.iter_mut().chain(&mut *directions) {
                row[kept.len()..padded].fill(0.0);
            }
            let d_values = &mut d_values[..padded * row_len];
            d_values[kept.len() * row_len..].fill(0.0);
            for (column, (k, row)) in
                kept.iter().zip(d_values.chunks_exact_mut(row_len)).enumerate()
            {
                let record = &self.records[k.sample as usize];
                let ray = record.ray as usize;
                for (row, p) in points.iter_mut().zip(record.point) {
                    row[column] = p;
                }
                let values = &self.values[record.row as usize * row_len..][..row_len];
                sigma[column] = values[0];
                if per_sample {
                    for (row, d) in directions.iter_mut().zip(self.rays[ray].ray.direction) {
                        row[column] = d;
                    }
                    colors.iter_mut().zip(&values[1..]).for_each(|(row, c)| row[column] = *c);
                }
                let d_sums = &self.sums[ray * row_len..][..row_len];
                for (value, d) in row.iter_mut().zip(d_sums) {
                    *value = k.weight * d;
                }
                row[0] = k.log_density;
            }
            back.samples(&SampleGradients {
                len: kept.len(),
                points: points.each_ref().map(|row| &row[..padded]),
                directions: directions.each_ref().map(|row| &row[..padded]),
                sigma: &sigma[..kept.len()],
                colors: colors.each_ref().map(|row| &row[..kept.len()]),
                gradients: d_values,
                row_len,
            });
            if let Some(poses) = &job.poses {
                // The points are no longer needed.
                let mut rows = points.each_mut().map(|row| &mut row[..padded]);
                rows.iter_mut().for_each(|row| row.fill(0.0));
                back.points(&poses.levels, rows);
                self.pull(kept, points.each_ref().map(|row| &row[..]), &job.space);
            }
        }
        self.kept = all;
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
