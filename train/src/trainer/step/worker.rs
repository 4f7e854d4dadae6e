//! Memory of one thread for a group's samples.

use pocketnerf_core::march::LANES;
use pocketnerf_core::scratch::Limits;

use crate::aligned::Aligned;
use crate::field::{BATCH, STRIDE};

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
    /// Mean features of rays.
    pub(super) features: Aligned<f32>,
    /// Gradients of their colours.
    pub(super) d_colors: Aligned<f32>,
    /// `[sample][row_len]`: gradients of a batch's values.
    pub(super) d_values: Aligned<f32>,
    /// Densities of a batch.
    pub(super) sigma: Aligned<f32>,
    /// Colours of a batch, where samples have their own.
    pub(super) colors: [Aligned<f32>; 3],
}

impl Worker {
    pub(crate) fn new(limits: Limits) -> Self {
        let rows = |n: usize| Aligned::new(n * STRIDE);
        let axes = || [rows(1), rows(1), rows(1)];
        let values = (1 + limits.channels).next_multiple_of(LANES);
        Self {
            a: rows(limits.width.max(limits.rows[0])),
            b: rows(limits.width.max(limits.rows[1])),
            output: rows(values),
            panel: Aligned::new(pocketnerf_core::network::panel_len(limits.width)),
            points: axes(),
            t: rows(1),
            directions: axes(),
            owners: vec![0; BATCH],
            steps: vec![1.0; BATCH],
            features: rows(limits.channels),
            d_colors: rows(3),
            d_values: Aligned::new(BATCH * values),
            sigma: rows(1),
            colors: axes(),
        }
    }
}
