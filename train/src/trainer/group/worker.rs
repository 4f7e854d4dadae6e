//! Memory of one thread.

use fearless_simd::Simd;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::scratch::{Limits, Workspace};
use pocketnerf_core::store::Store;

use super::{BATCH, STRIDE};
use crate::aligned::Aligned;
use crate::field::{Backward, Gradients};
use pocketnerf_core::sampler::LANES;

/// Memory of one thread.
#[derive(Debug)]
pub(crate) struct Worker {
    pub(super) a: Aligned<f32>,
    pub(super) b: Aligned<f32>,
    pub(super) output: Aligned<f32>,
    pub(super) panel: Aligned<f32>,
    pub(super) points: [Aligned<f32>; 3],
    /// Distances along the rays.
    pub(super) t: Aligned<f32>,
    pub(super) directions: [Aligned<f32>; 3],
    /// Number of the ray that each sample of a batch lies on.
    pub(super) owners: Vec<u32>,
    /// Steps that each stands for.
    pub(super) steps: Vec<f32>,
    pub(super) color_input: Aligned<f32>,
    pub(super) d_color_input: Aligned<f32>,
    pub(super) gradients: Gradients,
    /// `[sample][row_len]`: gradients of a batch's values.
    pub(super) d_values: Aligned<f32>,
}

impl Worker {
    pub(crate) fn new(limits: Limits, backward: &Backward) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        let axes = || [rows(1), rows(1), rows(1)];
        Self {
            a: rows(limits.width),
            b: rows(limits.width),
            output: rows((1 + limits.channels).next_multiple_of(LANES)),
            panel: Aligned::new(pocketnerf_core::network::panel_len(limits.width)),
            points: axes(),
            t: rows(1),
            directions: axes(),
            owners: vec![0; BATCH],
            steps: vec![1.0; BATCH],
            color_input: rows(limits.width),
            d_color_input: rows(limits.width),
            gradients: backward.buffers(STRIDE),
            d_values: Aligned::new(BATCH * (1 + limits.channels).next_multiple_of(LANES)),
        }
    }

    /// Unit coordinates of a batch.
    pub(crate) fn points(&mut self) -> &mut [Aligned<f32>; 3] {
        &mut self.points
    }

    /// What the field gave.
    pub(crate) fn output(&self) -> &[f32] {
        &self.output
    }

    /// Points, directions and the field's workspace.
    pub(crate) fn parts(&mut self) -> (&[Aligned<f32>; 3], &[Aligned<f32>; 3], Workspace<'_>) {
        let Self { a, b, output, panel, points, directions, .. } = self;
        (points, directions, Workspace { a, b, output, panel, stride: STRIDE })
    }

    /// From the features in the first rows of `color_input` and the directions
    /// to colours in the first three rows of `output`.
    #[inline(always)]
    pub(super) fn colors<S: Simd, T: Store>(
        &mut self,
        simd: S,
        decoder: &Decoder<'_>,
        backward: &Backward,
        n: usize,
    ) {
        let Self { output, directions, color_input, gradients, .. } = self;
        let harmonics = &mut color_input[decoder.n_features as usize * STRIDE..];
        let directions = [0, 1, 2].map(|axis| &directions[axis][..]);
        decoder.harmonics(simd, directions, n, harmonics, STRIDE);
        backward.color_forward::<S, T>(simd, decoder, color_input, gradients, n, output);
    }
}
