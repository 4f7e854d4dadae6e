//! Memory of one thread.

use fearless_simd::Simd;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::scratch::Limits;

use pocketnerf_core::march::{Hierarchical, LANES};
use pocketnerf_core::network::blocks::BLOCK;

use super::group::{BATCH, STRIDE};
use super::paper::RAYS;
use crate::aligned::Aligned;
use crate::field::{Backward, Gradients, NerfGradients, NerfWork, Tape};

/// Memory of one thread.
#[derive(Debug)]
pub(crate) struct Worker {
    pub(crate) a: Aligned<f32>,
    pub(crate) b: Aligned<f32>,
    pub(crate) output: Aligned<f32>,
    pub(crate) panel: Aligned<f32>,
    pub(crate) points: [Aligned<f32>; 3],
    /// Distances along the rays.
    pub(crate) t: Aligned<f32>,
    pub(crate) directions: [Aligned<f32>; 3],
    /// Number of the ray that each sample of a batch lies on.
    pub(crate) owners: Vec<u32>,
    /// Steps that each stands for.
    pub(crate) steps: Vec<f32>,
    pub(crate) color_input: Aligned<f32>,
    pub(crate) d_color_input: Aligned<f32>,
    pub(crate) gradients: Gradients,
    /// `[sample][row_len]`: gradients of a batch's values.
    pub(crate) d_values: Aligned<f32>,
    /// For the paper's field.
    pub(crate) nerf: Option<NerfWorker>,
}

/// Memory of one thread for the paper's field.
#[derive(Debug)]
pub(crate) struct NerfWorker {
    /// What the networks gave: the fine one, then the coarse one where it is trained.
    pub(crate) tapes: [Tape; 2],
    pub(crate) work: NerfWork,
}

/// Samples of the paper's field that go back together: what a layer gave for them,
/// half a megabyte, stays in a core's second-level cache until it has been read twice.
pub(crate) const NERF_BATCH: usize = 512;

impl NerfWorker {
    fn new(gradients: &NerfGradients, sampling: Option<Hierarchical>) -> Self {
        let most = sampling.map_or([NERF_BATCH, 0], |sampling| {
            let coarse = sampling.n_coarse as usize;
            [sampling.n_all(), coarse].map(|n| RAYS * n.next_multiple_of(BLOCK))
        });
        Self {
            tapes: most.map(|samples| Tape::new(gradients.config(), samples)),
            work: gradients.work(most[0]),
        }
    }
}

impl Worker {
    pub(crate) fn new(limits: Limits, backward: &Backward, sampling: Option<Hierarchical>) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        let axes = || [rows(1), rows(1), rows(1)];
        Self {
            a: rows(limits.width.max(limits.rows[0])),
            b: rows(limits.width.max(limits.rows[1])),
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
            nerf: backward.nerf().map(|gradients| NerfWorker::new(gradients, sampling)),
        }
    }

    /// From the features in the first rows of `color_input` and the directions
    /// to colours in the first three rows of `output`.
    #[inline(always)]
    pub(crate) fn colors<S: Simd>(
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
        backward.color_forward(simd, decoder, color_input, gradients, n, output);
    }
}
