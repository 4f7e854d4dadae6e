//! A fixed share of a step's rays, forwards and backwards.
//!
//! A step is cut into the same groups at any thread count, and every group
//! adds up its own gradients, so that the sums never depend on who worked when.

use fearless_simd::Simd;
use pocketnerf_core::composite::{self, Gathered};
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::field::{Field, Samples, Shading};
use pocketnerf_core::sampler::{Marcher, Path};
use pocketnerf_core::scratch::{Limits, Tuning, Workspace};
use pocketnerf_core::store::Store;

use super::rays::{RaySource, TrainingRay};
use crate::field::{Backward, Gradients};
use crate::random::Random;

/// Samples a batch; rows lie [`STRIDE`] values apart.
const BATCH: usize = 512;
/// Distance between the rows of a batch.
pub(crate) const STRIDE: usize = Tuning { samples: BATCH, rays: 1 }.stride();
/// Samples that a ray adds to a batch at a time.
const RUN: usize = 8;
/// A ray ends in training where its transmittance falls below this.
const MIN_TRANSMITTANCE: f32 = 1e-4;

/// What all groups of a step share.
#[derive(Debug)]
pub(crate) struct Job<'j> {
    pub(crate) marcher: Marcher<'j>,
    pub(crate) backward: &'j Backward,
    /// Distance between samples, scene units.
    pub(crate) step: f32,
    /// Gradients at least this large are always kept; smaller ones in
    /// proportion to their size, and enlarged accordingly. 0: all are kept.
    pub(crate) roulette: f32,
}

/// Memory of one thread.
#[derive(Debug)]
pub(crate) struct Worker {
    a: Vec<f32>,
    b: Vec<f32>,
    output: Vec<f32>,
    panel: Vec<f32>,
    points: [Vec<f32>; 3],
    directions: [Vec<f32>; 3],
    color_input: Vec<f32>,
    d_color_input: Vec<f32>,
    gradients: Gradients,
}

impl Worker {
    pub(crate) fn new(limits: Limits, backward: &Backward) -> Self {
        let rows = |n: usize| vec![0.0; n * STRIDE];
        let axes = || [rows(1), rows(1), rows(1)];
        Self {
            a: rows(limits.width),
            b: rows(limits.width),
            output: rows(1 + limits.channels),
            panel: vec![0.0; pocketnerf_core::network::panel_len(limits.width)],
            points: axes(),
            directions: axes(),
            color_input: rows(limits.width),
            d_color_input: rows(limits.width),
            gradients: backward.buffers(STRIDE),
        }
    }

    /// Unit coordinates of a batch.
    pub(crate) fn points(&mut self) -> &mut [Vec<f32>; 3] {
        &mut self.points
    }

    /// What the field gave.
    pub(crate) fn output(&self) -> &[f32] {
        &self.output
    }

    /// Points, directions and the field's workspace.
    pub(crate) fn parts(&mut self) -> (&[Vec<f32>; 3], &[Vec<f32>; 3], Workspace<'_>) {
        let Self { a, b, output, panel, points, directions, .. } = self;
        (points, directions, Workspace { a, b, output, panel, stride: STRIDE })
    }

    fn workspace(&mut self) -> Workspace<'_> {
        let Self { a, b, output, panel, .. } = self;
        Workspace { a, b, output, panel, stride: STRIDE }
    }
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
struct Traveller {
    path: Path,
    gathered: Gathered,
    run: usize,
}

/// What the backward pass needs of a sample.
#[derive(Clone, Copy, Debug)]
struct Record {
    point: [f32; 3],
    ray: u32,
    sigma: f32,
    weight: f32,
    /// Light that passes the sample.
    transmittance: f32,
}

/// The gradient that a ray hands to its samples.
#[derive(Clone, Copy, Debug, Default)]
struct RayGradient {
    /// Of the opacity.
    opacity: f32,
    /// Sum of the magnitudes of the channels' gradients.
    size: f32,
}

/// A sample whose gradient goes on to the network.
#[derive(Clone, Copy, Debug)]
struct Kept {
    sample: u32,
    /// Gradient of the log density.
    log_density: f32,
    /// Weight of the ray's channel gradients.
    weight: f32,
}

/// What a group found out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupStats {
    /// Sum of squared errors over rays and colours.
    pub(crate) squared_error: f64,
    /// Sum of opacities over rays.
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
    rays: Vec<TrainingRay>,
    random: Option<Random>,
    travellers: Vec<Traveller>,
    /// `[ray][channels]`: what each ray gathered; later its gradient.
    sums: Vec<f32>,
    ray_gradients: Vec<RayGradient>,
    records: Vec<Record>,
    /// `[sample][channels]`.
    features: Vec<f32>,
    suffix: Vec<f32>,
    kept: Vec<Kept>,
    /// Blocks of `[3 + n_encoded][STRIDE]`: points and gradients for the scatter.
    pub(crate) blocks: Vec<f32>,
    /// Points in each block, a multiple of 32.
    pub(crate) block_lens: Vec<usize>,
    /// Gradient of the networks' parameters.
    pub(crate) network_gradient: Vec<f32>,
    pub(crate) stats: GroupStats,
}

impl Group {
    /// A group for networks with so many parameters.
    pub(crate) fn new(n_network: usize) -> Self {
        Self { network_gradient: vec![0.0; n_network], ..Self::default() }
    }

    /// Draws `n` rays from the stream of this place.
    pub(crate) fn draw(&mut self, source: &RaySource, n: usize, mut random: Random) {
        self.rays.clear();
        self.rays.extend((0..n).map(|_| source.draw(&mut random)));
        self.random = Some(random);
    }

    /// Everything: march, shade, and both backward passes.
    #[inline(always)]
    pub(crate) fn run<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        self.stats = GroupStats::default();
        self.network_gradient.fill(0.0);
        self.march::<S, T, F>(simd, field, job, worker);
        match field.decoder().shading {
            Shading::PerRay => self.shade::<S, T, F>(simd, field, job, worker),
            Shading::PerSample => self.compare(),
        }
        self.sample_gradients(job, field.decoder().channels());
        self.back_through_networks::<S, T, F>(simd, field, job, worker);
    }

    /// Forward: density and features along every ray until it is opaque.
    #[inline(always)]
    fn march<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let channels = field.decoder().channels();
        let per_sample = field.decoder().shading == Shading::PerSample;
        self.records.clear();
        self.features.clear();
        self.sums.clear();
        self.sums.resize(self.rays.len() * channels, 0.0);
        self.travellers.clear();
        self.travellers.extend(self.rays.iter().map(|r| Traveller {
            path: job.marcher.path(r.ray, r.phase),
            gathered: Gathered::NOTHING,
            run: 0,
        }));
        loop {
            let mut n = 0;
            for traveller in &mut self.travellers {
                let start = n;
                if traveller.path.next < traveller.path.end && n < BATCH {
                    let [x, y, z] = &mut worker.points;
                    let room = RUN.min(BATCH - n);
                    job.marcher.advance(&mut traveller.path, room, |_, u| {
                        [x[n], y[n], z[n]] = u;
                        n += 1;
                    });
                    if per_sample {
                        let direction = traveller.path.ray.direction;
                        for (row, d) in worker.directions.iter_mut().zip(direction) {
                            row[start..n].fill(d);
                        }
                    }
                }
                traveller.run = n - start;
            }
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
            self.composite(worker, channels);
        }
    }

    /// Adds a batch to its rays and records what going back will need.
    #[inline(always)]
    fn composite(&mut self, worker: &Worker, channels: usize) {
        let (sigmas, rows) = worker.output.split_at(STRIDE);
        let mut start = 0;
        let sums = self.sums.chunks_exact_mut(channels);
        for (r, (traveller, sums)) in self.travellers.iter_mut().zip(sums).enumerate() {
            let run = start..start + traveller.run;
            start = run.end;
            for s in run {
                let weight = traveller.gathered.add(worker.a[s], 0.0);
                let first = self.features.len();
                self.features.extend(rows.chunks(STRIDE).take(channels).map(|row| row[s]));
                for (sum, value) in sums.iter_mut().zip(&self.features[first..]) {
                    *sum += weight * value;
                }
                self.records.push(Record {
                    point: [worker.points[0][s], worker.points[1][s], worker.points[2][s]],
                    ray: r as u32,
                    sigma: sigmas[s],
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

    /// The squared error of a ray's colour: adds to the statistics and gives
    /// the gradient of the colour.
    #[inline(always)]
    fn error(stats: &mut GroupStats, ray: &TrainingRay, color: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|c| {
            let difference = color[c] - ray.target[c];
            stats.squared_error += f64::from(difference * difference);
            // Adam is indifferent to the scale of the loss: no mean is taken.
            difference
        })
    }

    /// Per-sample shading: the sums are the colour over black.
    fn compare(&mut self) {
        self.ray_gradients.clear();
        let sums = self.sums.as_chunks_mut::<3>().0;
        for ((ray, traveller), sum) in self.rays.iter().zip(&self.travellers).zip(sums) {
            let opacity = traveller.gathered.opacity;
            self.stats.opacity += f64::from(opacity);
            let color = [0, 1, 2].map(|c| sum[c] + (1.0 - opacity) * ray.background[c]);
            let d_color = Self::error(&mut self.stats, ray, color);
            *sum = d_color;
            self.ray_gradients.push(RayGradient {
                opacity: -(0..3).map(|c| d_color[c] * ray.background[c]).sum::<f32>(),
                size: d_color.iter().map(|d| d.abs()).sum(),
            });
        }
    }

    /// Deferred shading: colour of every ray that met something, the error,
    /// and back through the colour network. `sums` become their gradients.
    #[inline(always)]
    fn shade<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let decoder = field.decoder();
        let channels = decoder.channels();
        self.ray_gradients.clear();
        self.ray_gradients.resize(self.rays.len(), RayGradient::default());
        let mut hits = Vec::with_capacity(BATCH);
        let mut next = 0;
        loop {
            hits.clear();
            while next < self.rays.len() && hits.len() < BATCH {
                if self.travellers[next].gathered.opacity > 0.0 {
                    hits.push(next);
                } else {
                    let background = self.rays[next].background;
                    let _ = Self::error(&mut self.stats, &self.rays[next], background);
                }
                next += 1;
            }
            if hits.is_empty() {
                return;
            }
            let padded = hits.len().next_multiple_of(32);
            for row in worker.color_input.chunks_mut(STRIDE) {
                row[hits.len()..padded].fill(0.0);
            }
            for row in &mut worker.directions {
                row[hits.len()..padded].fill(0.0);
            }
            for (column, &r) in hits.iter().enumerate() {
                let traveller = &self.travellers[r];
                let sums = &self.sums[r * channels..][..channels];
                let rows = worker.color_input.chunks_mut(STRIDE);
                for (row, sum) in rows.zip(sums) {
                    row[column] = sum / traveller.gathered.opacity;
                }
                let direction = traveller.path.ray.direction;
                let mut harmonics = [0.0; 16];
                spherical_harmonics::evaluate(decoder.sh_degree, direction, &mut harmonics);
                let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
                let rows = worker.color_input.chunks_mut(STRIDE).skip(channels);
                for (row, value) in rows.zip(&harmonics[..n_harmonics]) {
                    row[column] = *value;
                }
                for (row, d) in worker.directions.iter_mut().zip(direction) {
                    row[column] = d;
                }
            }
            let n_features = channels * STRIDE;
            worker.a[..n_features].copy_from_slice(&worker.color_input[..n_features]);
            let directions = worker.directions.clone();
            let axes = [0, 1, 2].map(|axis| directions[axis].as_slice());
            decoder.colors::<S, T>(simd, axes, padded, &mut worker.workspace());
            // Gradient of the colour network's outputs, before the logistic.
            let rows = worker.gradients.rows();
            for row in rows.chunks_mut(STRIDE).take(3) {
                row[..padded].fill(0.0);
            }
            for (column, &r) in hits.iter().enumerate() {
                let opacity = self.travellers[r].gathered.opacity;
                let ray = &self.rays[r];
                let rgb = [0, 1, 2].map(|c| worker.output[(1 + c) * STRIDE + column]);
                let color =
                    [0, 1, 2].map(|c| opacity * rgb[c] + (1.0 - opacity) * ray.background[c]);
                let d_color = Self::error(&mut self.stats, ray, color);
                self.stats.opacity += f64::from(opacity);
                for c in 0..3 {
                    let slope = rgb[c] * (1.0 - rgb[c]);
                    rows[c * STRIDE + column] = opacity * d_color[c] * slope;
                }
                self.ray_gradients[r].opacity =
                    (0..3).map(|c| d_color[c] * (rgb[c] - ray.background[c])).sum();
            }
            job.backward.color::<S, T>(
                simd,
                decoder,
                &worker.color_input,
                &mut worker.gradients,
                padded,
                &mut self.network_gradient,
                &mut worker.d_color_input,
            );
            for (column, &r) in hits.iter().enumerate() {
                let inverse = 1.0 / self.travellers[r].gathered.opacity;
                let gradient = &mut self.ray_gradients[r];
                let d_rows = worker.d_color_input.chunks(STRIDE);
                let rows = worker.color_input.chunks(STRIDE);
                let sums = &mut self.sums[r * channels..][..channels];
                for ((sum, d_row), row) in sums.iter_mut().zip(d_rows).zip(rows) {
                    // feature = sum / opacity.
                    let d_sum = d_row[column] * inverse;
                    *sum = d_sum;
                    gradient.opacity -= d_sum * row[column];
                    gradient.size += d_sum.abs();
                }
            }
        }
    }

    /// From rays to samples, back to front: the derivative of the volume
    /// rendering sum. Small gradients are dropped at random and the rest
    /// enlarged, so that the expected sum is the same.
    fn sample_gradients(&mut self, job: &Job<'_>, channels: usize) {
        let Self { records, features, sums, ray_gradients, suffix, kept, stats, random, .. } = self;
        suffix.clear();
        suffix.resize(ray_gradients.len(), 0.0);
        kept.clear();
        let mut random = random.take().expect("set with the rays");
        for (s, record) in records.iter().enumerate().rev() {
            let r = record.ray as usize;
            let d_sums = &sums[r * channels..][..channels];
            let values = &features[s * channels..][..channels];
            let along: f32 = d_sums.iter().zip(values).map(|(d, f)| d * f).sum();
            let d_weight = ray_gradients[r].opacity + along;
            let d_sigma = job.step * (record.transmittance * d_weight - suffix[r]);
            suffix[r] += record.weight * d_weight;
            let log_density = d_sigma * record.sigma;
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
    }

    /// From samples to network weights and encoded points.
    #[inline(always)]
    fn back_through_networks<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
    ) {
        let decoder = field.decoder();
        let channels = decoder.channels();
        let n_encoded = field.n_encoded();
        let block_size = (3 + n_encoded) * STRIDE;
        self.block_lens.clear();
        let n_blocks = self.kept.len().div_ceil(BATCH);
        if self.blocks.len() < n_blocks * block_size {
            self.blocks.resize(n_blocks * block_size, 0.0);
        }
        for (kept, block) in self.kept.chunks(BATCH).zip(self.blocks.chunks_mut(block_size)) {
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
            field.encode::<S, T>(simd, points, &mut worker.a, STRIDE);
            let rows = worker.gradients.rows();
            for row in rows.chunks_mut(STRIDE).take(1 + channels) {
                row[kept.len()..padded].fill(0.0);
            }
            for (column, k) in kept.iter().enumerate() {
                let r = self.records[k.sample as usize].ray as usize;
                rows[column] = k.log_density;
                let d_sums = &self.sums[r * channels..][..channels];
                for (row, d) in rows[STRIDE..].chunks_mut(STRIDE).zip(d_sums) {
                    row[column] = k.weight * d;
                }
            }
            if decoder.shading == Shading::PerSample {
                Self::back_through_color::<S, T, F>(
                    simd,
                    field,
                    job,
                    worker,
                    kept,
                    &self.records,
                    &self.travellers,
                    &mut self.network_gradient,
                );
            }
            let wanted = (n_encoded > 0).then_some(&mut *d_encoded);
            job.backward.density::<S, T>(
                simd,
                decoder,
                &worker.a,
                &mut worker.gradients,
                padded,
                &mut self.network_gradient,
                wanted,
            );
        }
    }

    /// Per-sample shading: from the gradient of each sample's colour (rows 1
    /// to 3 of the gradient) to that of its features. Keeps `worker.a`.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "parts of a group that are borrowed apart")]
    fn back_through_color<S: Simd, T: Store, F: Field>(
        simd: S,
        field: &F,
        job: &Job<'_>,
        worker: &mut Worker,
        kept: &[Kept],
        records: &[Record],
        travellers: &[Traveller],
        network_gradient: &mut [f32],
    ) {
        let decoder = field.decoder();
        let n_features = decoder.n_features as usize;
        let padded = kept.len().next_multiple_of(32);
        let encoded = worker.a[..field.n_encoded() * STRIDE].to_vec();
        for row in &mut worker.directions {
            row[kept.len()..padded].fill(0.0);
        }
        for (column, k) in kept.iter().enumerate() {
            let r = records[k.sample as usize].ray as usize;
            let direction = travellers[r].path.ray.direction;
            for (row, d) in worker.directions.iter_mut().zip(direction) {
                row[column] = d;
            }
        }
        // Features again, then colours.
        {
            let Worker { a, b, output, panel, .. } = &mut *worker;
            decoder.density.forward::<S, T>(simd, a, b, output, padded, STRIDE, panel);
        }
        let features = &worker.output[STRIDE..(1 + n_features) * STRIDE];
        worker.color_input[..features.len()].copy_from_slice(features);
        let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
        for column in 0..padded {
            let direction = [0, 1, 2].map(|axis| worker.directions[axis][column]);
            let mut harmonics = [0.0; 16];
            spherical_harmonics::evaluate(decoder.sh_degree, direction, &mut harmonics);
            for (i, value) in harmonics[..n_harmonics].iter().enumerate() {
                worker.color_input[(n_features + i) * STRIDE + column] = *value;
            }
        }
        worker.a[..n_features * STRIDE].copy_from_slice(&worker.color_input[..n_features * STRIDE]);
        let directions = worker.directions.clone();
        let axes = [0, 1, 2].map(|axis| directions[axis].as_slice());
        decoder.colors::<S, T>(simd, axes, padded, &mut worker.workspace());
        let rows = worker.gradients.rows();
        let log_density = rows[..padded].to_vec();
        for c in 0..3 {
            for column in 0..padded {
                let rgb = worker.output[(1 + c) * STRIDE + column];
                rows[c * STRIDE + column] = rows[(1 + c) * STRIDE + column] * rgb * (1.0 - rgb);
            }
        }
        job.backward.color::<S, T>(
            simd,
            decoder,
            &worker.color_input,
            &mut worker.gradients,
            padded,
            network_gradient,
            &mut worker.d_color_input,
        );
        let rows = worker.gradients.rows();
        rows[..padded].copy_from_slice(&log_density);
        rows[STRIDE..(1 + n_features) * STRIDE]
            .copy_from_slice(&worker.d_color_input[..n_features * STRIDE]);
        worker.a[..encoded.len()].copy_from_slice(&encoded);
    }
}
