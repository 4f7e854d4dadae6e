//! Forwards through the network, with everything that the way back needs.

use fearless_simd::{Simd, SimdBase};
use pocketnerf_core::encoding::Affine;
use pocketnerf_core::field::NerfField;
use pocketnerf_core::lanes;
use pocketnerf_core::network::blocks::{BLOCK, Blocks, Row, dense_blocks};
use pocketnerf_core::network::panel_len;

use super::NerfConfig;
use crate::aligned::Aligned;
use crate::field::logistic::before_logistic;

/// Rows of samples, block after block.
#[derive(Debug)]
pub(super) struct Rows {
    values: Aligned<f32>,
    pub(super) per_block: usize,
}

impl Rows {
    fn new(per_block: usize, blocks: usize) -> Self {
        Self { values: Aligned::new(per_block * blocks * BLOCK), per_block }
    }

    /// The rows of the first `blocks` blocks.
    pub(super) fn blocks(&self, blocks: usize) -> Blocks<'_> {
        let rows = &self.values.as_chunks().0[..blocks * self.per_block];
        Blocks { rows, per_block: self.per_block }
    }

    pub(super) fn rows_mut(&mut self, blocks: usize) -> &mut [Row] {
        &mut self.values.as_chunks_mut().0[..blocks * self.per_block]
    }
}

/// What every layer gave for a batch of samples.
#[derive(Debug)]
pub(in crate::field) struct NerfTape {
    pub(super) encoded: Rows,
    pub(super) directions: Rows,
    /// After ReLU.
    pub(super) trunk: Vec<Rows>,
    /// The density before its activation; later its gradient.
    pub(super) density: Rows,
    pub(super) feature: Rows,
    /// After ReLU.
    pub(super) color: Rows,
    /// Colours in [0, 1]; later the gradient of what was before the logistic.
    pub(super) rgb: Rows,
    panel: Aligned<f32>,
    /// Samples, filled up to whole blocks.
    len: usize,
}

impl NerfTape {
    /// For so many samples at most.
    pub(in crate::field) fn new(config: &NerfConfig, samples: usize) -> Self {
        let blocks = samples.div_ceil(BLOCK);
        let rows = |n| Rows::new(n, blocks);
        let most_inputs = config.layers().map(|layer| config.shape(layer)[0]).max().unwrap_or(0);
        Self {
            encoded: rows(config.positions.n_output()),
            directions: rows(config.n_direction()),
            trunk: (0..config.depth).map(|_| rows(config.width)).collect(),
            density: rows(1),
            feature: rows(config.width),
            color: rows(config.color_width),
            rgb: rows(3),
            panel: Aligned::new(panel_len(most_inputs)),
            len: 0,
        }
    }

    /// Blocks in use.
    pub(super) fn n_blocks(&self) -> usize {
        self.len.div_ceil(BLOCK)
    }

    /// Through the fine network of `field`, at unit `points` along `directions`, whose
    /// number is a multiple of 16. Then [`raw`](Self::raw) and [`color`](Self::color) are
    /// known.
    #[inline(always)]
    pub(in crate::field) fn forward<S: Simd>(
        &mut self,
        simd: S,
        field: &NerfField<'_>,
        points: [&[f32]; 3],
        directions: [&[f32]; 3],
    ) {
        self.len = points[0].len();
        let n = self.n_blocks();
        let encoded = self.encoded.rows_mut(n);
        simd.vectorize(
            #[inline(always)]
            || field.positions.encode(simd, points, field.map, encoded),
        );
        let mut second = Blocks::NONE;
        if let Some(encoding) = &field.directions {
            let encoded = self.directions.rows_mut(n);
            simd.vectorize(
                #[inline(always)]
                || encoding.encode(simd, directions, Affine::IDENTITY, encoded),
            );
            second = self.directions.blocks(n);
        }
        let network = &field.fine;
        let panel = &mut self.panel[..];
        for (i, dense) in network.trunk().iter().enumerate() {
            let (done, next) = self.trunk.split_at_mut(i);
            let encoded = self.encoded.blocks(n);
            let x = match done.last() {
                None => [encoded, Blocks::NONE],
                Some(x) if network.skips(i) => [encoded, x.blocks(n)],
                Some(x) => [x.blocks(n), Blocks::NONE],
            };
            dense_blocks(simd, dense, x, next[0].rows_mut(n), network.relu_after(i), panel);
        }
        let Some(trunk) = self.trunk.last() else { return };
        let mut x = trunk.blocks(n);
        let y = self.density.rows_mut(n);
        dense_blocks(simd, &network.density, [x, Blocks::NONE], y, false, panel);
        if let Some(feature) = &network.feature {
            let y = self.feature.rows_mut(n);
            dense_blocks(simd, feature, [x, Blocks::NONE], y, false, panel);
            x = self.feature.blocks(n);
        }
        if let [hidden, last] = network.color.layers() {
            let y = self.color.rows_mut(n);
            dense_blocks(simd, hidden, [x, second], y, true, panel);
            let x = [self.color.blocks(n), Blocks::NONE];
            dense_blocks(simd, last, x, self.rgb.rows_mut(n), false, panel);
        }
        simd.vectorize(
            #[inline(always)]
            || {
                for values in self.rgb.rows_mut(n).as_flattened_mut().chunks_exact_mut(S::f32s::LEN)
                {
                    lanes::logistic(simd, S::f32s::from_slice(simd, values)).store_slice(values);
                }
            },
        );
    }

    /// The density of each sample before its activation.
    pub(super) fn raw(&mut self) -> &mut [f32] {
        let n = self.n_blocks();
        self.density.rows_mut(n).as_flattened_mut()
    }

    /// A sample's colour.
    pub(super) fn color(&self, s: usize) -> [f32; 3] {
        let rows = &self.rgb.blocks(self.n_blocks()).rows[s / BLOCK * 3..][..3];
        [0, 1, 2].map(|c| rows[c][s % BLOCK])
    }

    /// Sets what is to go back of a sample: the gradients of the density before its
    /// activation and of the colour, which becomes that before its logistic.
    pub(in crate::field) fn set_gradient(&mut self, s: usize, d_raw: f32, d_rgb: [f32; 3]) {
        let n = self.n_blocks();
        self.density.rows_mut(n).as_flattened_mut()[s] = d_raw;
        let rows = &mut self.rgb.rows_mut(n)[s / BLOCK * 3..][..3];
        for (row, d) in rows.iter_mut().zip(d_rgb) {
            let value = &mut row[s % BLOCK];
            *value = before_logistic(*value, d);
        }
    }

    /// Sets the gradients of the samples from `first` on to 0: they fill up the last
    /// block.
    pub(in crate::field) fn clear_from(&mut self, first: usize) {
        for s in first..self.n_blocks() * BLOCK {
            self.set_gradient(s, 0.0, [0.0; 3]);
        }
    }
}
