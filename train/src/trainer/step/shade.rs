//! From what rays accumulated to their colours, the error, and back.

use super::group::{Group, Job, MIN_TRANSMITTANCE, RayGradient, Worker, row_len};
use crate::field::{BATCH, Back, STRIDE};
use crate::stopwatch::{Laps, Stage};
use crate::trainer::loss::{RayLoss, Rendered, loss};

impl Group {
    /// The loss of a ray, noted.
    #[inline(always)]
    pub(super) fn loss(&mut self, job: &Job<'_>, ray: usize, rendered: &Rendered) -> RayLoss {
        let weight = f64::from(self.rays[ray].weight);
        let loss = loss(job.terms, &self.rays[ray], rendered);
        self.errors[ray] = loss.squared_error / 3.0;
        if job.evened_out > 0 {
            let sums = &mut self.d_gains[self.pixels[ray].view as usize];
            sums.iter_mut().zip(loss.d_log_gain).for_each(|(sum, d)| *sum += d);
        }
        // Of photographs: what others show of the scene is no measure. Rays that are drawn anywhere
        // have no pixels noted.
        if self.pixels.get(ray).is_none_or(|pixel| pixel.view < job.n_photographs) {
            self.stats.squared_error += weight * f64::from(loss.squared_error);
            self.stats.opacity += weight * f64::from(rendered.opacity);
        }
        loss
    }

    /// The loss of a ray that met nothing.
    #[inline(always)]
    pub(super) fn loss_of_nothing(&mut self, job: &Job<'_>, ray: usize) {
        let color = self.rays[ray].background;
        let _ = self.loss(job, ray, &Rendered { color, opacity: 0.0, depth: 0.0 });
    }

    /// Per-sample shading: the sums are the colour over black, and of a ray that
    /// has ended, their mean is its colour.
    pub(super) fn compare(&mut self, job: &Job<'_>, row_len: usize) {
        self.ray_gradients.clear();
        for r in 0..self.rays.len() {
            let (accumulated, background) = (self.accumulated[r], self.rays[r].background);
            let ended = accumulated.transmittance < MIN_TRANSMITTANCE;
            let scale = if ended { 1.0 / accumulated.opacity } else { 1.0 };
            let opacity = accumulated.alpha(MIN_TRANSMITTANCE);
            let sums = r * row_len..(r + 1) * row_len;
            let over_black = [0, 1, 2].map(|c| scale * self.sums[sums.start + 1 + c]);
            let color = [0, 1, 2].map(|c| over_black[c] + (1.0 - opacity) * background[c]);
            let rendered = Rendered { color, opacity, depth: accumulated.depth };
            let loss = self.loss(job, r, &rendered);
            let d_sum = loss.d_color.map(|d| scale * d);
            // Features fill the rest of the row: nothing depends on their sums.
            let sums = &mut self.sums[sums];
            sums.fill(0.0);
            sums[1..4].copy_from_slice(&d_sum);
            let unlike = |c: usize| if ended { over_black[c] } else { background[c] };
            let d_opacity = if ended { 0.0 } else { loss.d_opacity };
            self.ray_gradients.push(RayGradient {
                opacity: d_opacity - (0..3).map(|c| d_sum[c] * unlike(c)).sum::<f32>(),
                depth: loss.d_depth,
                size: d_sum.iter().map(|d| d.abs()).sum(),
            });
        }
    }

    /// Deferred shading: colour of every ray that met something, the error,
    /// and back through the colour network. `sums` become their gradients.
    #[inline(always)]
    pub(super) fn shade(
        &mut self,
        (channels, sh_degree): (usize, u32),
        job: &Job<'_>,
        worker: &mut Worker,
        back: &mut dyn Back,
    ) {
        let mut laps = Laps::begin(job.stopwatch);
        let row_len = row_len(channels);
        self.ray_gradients.clear();
        self.ray_gradients.resize(self.rays.len(), RayGradient::default());
        let mut hits = Vec::with_capacity(BATCH);
        let mut next = 0;
        loop {
            hits.clear();
            while next < self.rays.len() && hits.len() < BATCH {
                if self.accumulated[next].opacity > 0.0 {
                    hits.push(next);
                } else {
                    self.loss_of_nothing(job, next);
                }
                next += 1;
            }
            if hits.is_empty() {
                laps.end(Stage::Shade, 0);
                return;
            }
            self.shade_hits(&hits, (channels, sh_degree, row_len), job, worker, back);
            laps.end(Stage::Shade, hits.len());
        }
    }

    /// The same for a batch of rays.
    #[inline(always)]
    fn shade_hits(
        &mut self,
        hits: &[usize],
        (channels, sh_degree, row_len): (usize, u32, usize),
        job: &Job<'_>,
        worker: &mut Worker,
        back: &mut dyn Back,
    ) {
        let padded = hits.len().next_multiple_of(32);
        let Worker { features, directions, d_colors, .. } = worker;
        let rows = features.chunks_mut(STRIDE).chain(d_colors.chunks_mut(STRIDE));
        for row in rows.chain(directions.iter_mut().map(|row| &mut row[..])) {
            row[hits.len()..padded].fill(0.0);
        }
        for (column, &r) in hits.iter().enumerate() {
            let sums = &self.sums[r * row_len + 1..][..channels];
            for (row, sum) in features.chunks_mut(STRIDE).zip(sums) {
                row[column] = sum / self.accumulated[r].opacity;
            }
            for (row, d) in directions.iter_mut().zip(self.blurred_direction(r, job.few_cameras)) {
                row[column] = d;
            }
        }
        let colors = back.colors(features, directions.each_ref().map(|row| &row[..]), padded);
        for (column, &r) in hits.iter().enumerate() {
            let opacity = self.accumulated[r].alpha(MIN_TRANSMITTANCE);
            let background = self.rays[r].background;
            let rgb = [0, 1, 2].map(|c| colors[c * STRIDE + column]);
            let color = [0, 1, 2].map(|c| opacity * rgb[c] + (1.0 - opacity) * background[c]);
            let depth = self.accumulated[r].depth;
            let loss = self.loss(job, r, &Rendered { color, opacity, depth });
            self.ray_gradients[r].depth = loss.d_depth;
            for c in 0..3 {
                d_colors[c * STRIDE + column] = opacity * loss.d_color[c];
            }
            // That of a ray that has ended is 1, whatever its samples.
            if opacity < 1.0 {
                let unlike = |c: usize| loss.d_color[c] * (rgb[c] - background[c]);
                self.ray_gradients[r].opacity = loss.d_opacity + (0..3).map(unlike).sum::<f32>();
            }
        }
        let d_features = back.colors_back(d_colors, padded);
        if job.poses.is_some() {
            let directions = directions.each_ref().map(|row| &row[..]);
            self.pull_directions(hits, directions, &d_features[channels * STRIDE..], sh_degree);
        }
        for (column, &r) in hits.iter().enumerate() {
            let inverse = 1.0 / self.accumulated[r].opacity;
            let gradient = &mut self.ray_gradients[r];
            let rows = d_features.chunks(STRIDE).zip(features.chunks(STRIDE));
            let sums = &mut self.sums[r * row_len..][..row_len];
            // Nothing depends on the sum of densities, nor on what fills up the row.
            sums.fill(0.0);
            for (sum, (d_row, row)) in sums[1..=channels].iter_mut().zip(rows) {
                // feature = sum / opacity.
                let d_sum = d_row[column] * inverse;
                *sum = d_sum;
                gradient.opacity -= d_sum * row[column];
                gradient.size += d_sum.abs();
            }
        }
        if let Some(cameras) = job.cameras {
            self.hold_between_views(hits, channels, cameras, worker, back);
        }
    }
}
