//! A group's way back: from batches of rays and samples to the networks' weights and to
//! encoded points, whose gradient the update scatters to the tables.

use std::sync::MutexGuard;

use fearless_simd::{Level, Simd, dispatch};
use pocketnerf_core::TensorView;
use pocketnerf_core::field::{Decoder, Shading};
use pocketnerf_core::lanes::{LANES, transpose};

use super::networks::{Gradients, Networks};
use super::{Encoding, TrainableEncoded};
use crate::aligned::Aligned;
use crate::field::logistic::before_logistic;
use crate::field::{Back, Context, STRIDE, SampleGradients};
use crate::pool::Lease;
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// Gradients of a group of rays.
#[derive(Debug, Default)]
pub(super) struct GroupGradients {
    /// Gradient of the networks' parameters.
    pub(super) networks: Vec<f32>,
    /// Blocks of `[3 + n_encoded][STRIDE]`: points and gradients for the scatter.
    blocks: Vec<f32>,
    /// Points in each block, a multiple of 32.
    block_lens: Vec<usize>,
}

impl GroupGradients {
    /// For networks with so many parameters.
    pub(super) fn new(n_network: usize) -> Self {
        Self { networks: vec![0.0; n_network], ..Self::default() }
    }

    /// All 0 again.
    pub(super) fn clear(&mut self) {
        self.networks.fill(0.0);
        self.block_lens.clear();
    }

    /// The next block.
    fn block(&mut self, size: usize, len: usize) -> (&mut [f32], &mut [f32]) {
        let first = self.block_lens.len() * size;
        self.block_lens.push(len);
        if self.blocks.len() < first + size {
            self.blocks.resize(first + size, 0.0);
        }
        (&mut self.blocks[first..first + size], &mut self.networks)
    }

    /// The points of the block that was added last, and the gradient of what they are encoded to.
    fn last_block(&self, n_encoded: usize) -> Option<([&[f32]; 3], &[f32])> {
        let (n, size) = (*self.block_lens.last()?, (3 + n_encoded) * STRIDE);
        let (points, rows) = self.blocks[(self.block_lens.len() - 1) * size..].split_at(3 * STRIDE);
        Some(([0, 1, 2].map(|a| &points[a * STRIDE..][..n]), rows))
    }

    /// Adds the gradient of a task's tables.
    #[inline(always)]
    pub(super) fn scatter<S: Simd, E: Encoding>(
        &self,
        simd: S,
        grid: &E,
        task: (usize, &[TensorView<'_>]),
        gradient: &mut [f32],
    ) {
        let blocks = self.blocks.chunks_exact((3 + grid.n_output()) * STRIDE);
        for (block, &n) in blocks.zip(&self.block_lens) {
            let (points, rows) = block.split_at(3 * STRIDE);
            let points = [0, 1, 2].map(|a| &points[a * STRIDE..][..n]);
            grid.scatter(simd, task, points, (rows, STRIDE), gradient);
        }
    }
}

/// Memory of one thread.
#[derive(Debug)]
pub(super) struct Worker {
    /// Encoded points.
    encoded: Aligned<f32>,
    /// Outputs of the density network, or colours.
    output: Aligned<f32>,
    color_input: Aligned<f32>,
    d_color_input: Aligned<f32>,
    gradients: Gradients,
}

impl Worker {
    fn new<E: Encoding>(field: &TrainableEncoded<E>) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        let width = field.networks.max_width;
        Self {
            encoded: rows(width),
            output: rows((1 + field.config.n_features).max(3).next_multiple_of(LANES)),
            color_input: rows(width),
            d_color_input: rows(width),
            gradients: field.networks.buffers(STRIDE),
        }
    }
}

/// The way back.
#[derive(Debug)]
pub(super) struct EncodedBack<'a, E: Encoding> {
    networks: &'a Networks,
    shape: &'a E,
    grid: E::View<'a>,
    decoder: Decoder<'a>,
    /// The tables' parameters, not rounded.
    tables: Vec<&'a [f32]>,
    level: Level,
    stopwatch: Option<&'a Stopwatch>,
    group: MutexGuard<'a, GroupGradients>,
    worker: Lease<'a, Worker>,
}

impl<'a, E: Encoding> EncodedBack<'a, E> {
    pub(super) fn new(
        owner: &'a TrainableEncoded<E>,
        group: MutexGuard<'a, GroupGradients>,
        context: Context<'a>,
    ) -> Self {
        let Context { level, stopwatch, parameters } = context;
        let training = owner.training_field(parameters);
        let (grid, decoder) = training.expect("checked when training began");
        let worker = owner.workers.lease(|| Worker::new(owner));
        let tables = owner.layout.tables().iter().map(|range| &parameters[range.indices()]);
        let tables = tables.collect();
        let (networks, shape) = (&owner.networks, &owner.config.grid);
        Self { networks, shape, grid, decoder, tables, level, stopwatch, group, worker }
    }
}

impl<E: Encoding> Back for EncodedBack<'_, E> {
    fn colors(&mut self, features: &[f32], directions: [&[f32]; 3], n: usize) -> &[f32] {
        let rows = features.chunks(STRIDE).take(self.decoder.n_features as usize);
        for (to, from) in self.worker.color_input.chunks_mut(STRIDE).zip(rows) {
            to[..n].copy_from_slice(&from[..n]);
        }
        dispatch!(self.level, simd => self.worker.colors(
            simd, &self.decoder, self.networks, directions, n,
        ));
        &self.worker.output
    }

    fn colors_back(&mut self, d_colors: &[f32], n: usize) -> &[f32] {
        let Worker { output, color_input, d_color_input, gradients, .. } = &mut *self.worker;
        // Before the logistic.
        let rows = gradients.rows().chunks_mut(STRIDE).zip(d_colors.chunks(STRIDE));
        for ((row, d_row), rgb) in rows.zip(output.chunks(STRIDE)).take(3) {
            for ((value, d), rgb) in row[..n].iter_mut().zip(d_row).zip(rgb) {
                *value = before_logistic(*rgb, *d);
            }
        }
        let weights = &mut self.group.networks;
        dispatch!(self.level, simd => self.networks.color(
            simd, color_input, gradients, n, weights, d_color_input,
        ));
        d_color_input
    }

    fn samples(&mut self, samples: &SampleGradients<'_>) {
        dispatch!(self.level, simd => self.samples_back(simd, samples));
    }

    fn points(&mut self, levels: &[f32], mut d_points: [&mut [f32]; 3]) {
        let Self { shape, tables, group, .. } = self;
        let Some((points, rows)) = group.last_block(shape.n_output()) else { return };
        dispatch!(self.level, simd => shape.points_back(
            simd, tables, points, (rows, STRIDE), levels, &mut d_points,
        ));
    }
}

impl<E: Encoding> EncodedBack<'_, E> {
    /// From samples to network weights and encoded points.
    #[inline(always)]
    fn samples_back<S: Simd>(&mut self, simd: S, samples: &SampleGradients<'_>) {
        let Self { networks, shape, grid, decoder, stopwatch, group, worker, .. } = self;
        let mut laps = Laps::begin(*stopwatch);
        let (row_len, n_encoded) = (samples.row_len, shape.n_output());
        let padded = samples.points[0].len();
        let (block, weights) = group.block((3 + n_encoded) * STRIDE, padded);
        let (points, d_encoded) = block.split_at_mut(3 * STRIDE);
        for (row, point) in points.chunks_mut(STRIDE).zip(samples.points) {
            row[..padded].copy_from_slice(point);
        }
        E::encode(simd, grid, samples.points, &mut worker.encoded, STRIDE);
        laps.end(Stage::EncodeAgain, samples.len);
        let rows = worker.gradients.rows();
        for (to, part) in rows.chunks_mut(LANES * STRIDE).zip((0..row_len).step_by(LANES)) {
            for at in (0..padded).step_by(LANES) {
                let from = &samples.gradients[at * row_len + part..];
                transpose(simd, (from, row_len, LANES), (&mut to[at..], STRIDE), LANES);
            }
        }
        if decoder.shading == Shading::PerSample {
            worker.through_color(simd, decoder, networks, samples, weights);
        } else {
            let Worker { encoded, gradients, .. } = &mut **worker;
            networks.density_forward(simd, decoder, encoded, gradients, padded, None);
        }
        let Worker { encoded, gradients, .. } = &mut **worker;
        networks.density(simd, encoded, gradients, padded, weights, Some(d_encoded));
        laps.end(Stage::Backward, samples.len);
    }
}

impl Worker {
    /// From the features in the first rows of `color_input` and the directions to colours
    /// in the first three rows of `output`.
    #[inline(always)]
    fn colors<S: Simd>(
        &mut self,
        simd: S,
        decoder: &Decoder<'_>,
        networks: &Networks,
        directions: [&[f32]; 3],
        n: usize,
    ) {
        let Self { output, color_input, gradients, .. } = self;
        let harmonics = &mut color_input[decoder.n_features as usize * STRIDE..];
        decoder.harmonics(simd, directions, n, harmonics, STRIDE);
        networks.color_forward(simd, decoder, color_input, gradients, n, output);
    }

    /// Per-sample shading: from the gradient of each sample's colour (rows 1 to 3 of the
    /// gradient) to that of its features.
    #[inline(always)]
    fn through_color<S: Simd>(
        &mut self,
        simd: S,
        decoder: &Decoder<'_>,
        networks: &Networks,
        samples: &SampleGradients<'_>,
        weights: &mut [f32],
    ) {
        let n_features = decoder.n_features as usize * STRIDE;
        let padded = samples.points[0].len();
        {
            let Self { encoded, gradients, output, color_input, .. } = self;
            let values = Some(&mut output[..]);
            networks.density_forward(simd, decoder, encoded, gradients, padded, values);
            color_input[..n_features].copy_from_slice(&output[STRIDE..STRIDE + n_features]);
        }
        self.colors(simd, decoder, networks, samples.directions, padded);
        let rows = self.gradients.rows();
        for c in 0..3 {
            for column in 0..padded {
                let rgb = self.output[c * STRIDE + column];
                let d = rows[(1 + c) * STRIDE + column];
                rows[c * STRIDE + column] = before_logistic(rgb, d);
            }
        }
        let Self { color_input, d_color_input, gradients, .. } = self;
        networks.color(simd, color_input, gradients, padded, weights, d_color_input);
        let rows = gradients.rows();
        for (value, row) in rows.iter_mut().zip(samples.gradients.chunks_exact(samples.row_len)) {
            *value = row[0];
        }
        rows[samples.len..padded].fill(0.0);
        rows[STRIDE..STRIDE + n_features].copy_from_slice(&d_color_input[..n_features]);
    }
}
