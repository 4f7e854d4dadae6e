//! The gradient of a layer's weights: the sum over all samples of the products of what
//! the layer read and the gradient of what it gave.
//!
//! Gradients are transposed, so that the outputs of one sample lie side by side: then
//! the same register tile as forwards, inputs times outputs, sums over samples without
//! ever adding up a register's lanes.

use fearless_simd::{Simd, SimdBase, SimdFloat};
use pocketnerf_core::lanes::transpose;
use pocketnerf_core::network::blocks::{BLOCK, Blocks, Row};

use crate::aligned::Aligned;

/// Inputs of a register tile.
const INPUTS: usize = 8;

/// Gradients of 32 outputs at a time, `[panel][block][sample]` rows of outputs.
#[derive(Debug)]
pub(super) struct Transposed {
    values: Aligned<f32>,
    n_out: usize,
    blocks: usize,
}

impl Transposed {
    /// Room for so many outputs of so many blocks.
    pub(super) fn new(n_out: usize, blocks: usize) -> Self {
        let len = n_out.next_multiple_of(BLOCK) * blocks * BLOCK;
        Self { values: Aligned::new(len), n_out: 0, blocks: 0 }
    }

    /// Takes over the gradient of a layer's outputs.
    #[inline(always)]
    pub(super) fn set<S: Simd>(&mut self, simd: S, gradient: Blocks<'_>) {
        let n_out = gradient.per_block;
        let blocks = gradient.rows.len() / n_out;
        (self.n_out, self.blocks) = (n_out, blocks);
        let tiles = self.values.as_chunks_mut::<{ BLOCK * BLOCK }>().0;
        let tiles = tiles.chunks_exact_mut(blocks.max(1));
        for (panel, tiles) in (0..n_out).step_by(BLOCK).zip(tiles) {
            for (rows, tile) in gradient.rows.chunks_exact(n_out).zip(tiles) {
                for half in [0, BLOCK / 2] {
                    let there = n_out.saturating_sub(panel + half).min(BLOCK / 2);
                    let from = rows.get(panel + half..).unwrap_or(&[]).as_flattened();
                    let to = &mut tile[half..];
                    transpose(simd, (from, BLOCK, there), (to, BLOCK), BLOCK);
                }
            }
        }
    }

    /// The tiles of a panel, one a block.
    fn panel(&self, panel: usize) -> &[[Row; BLOCK]] {
        let rows = self.values.as_chunks::<BLOCK>().0;
        &rows.as_chunks::<BLOCK>().0[panel * self.blocks..][..self.blocks]
    }

    /// Adds to the gradient of the biases, `[n_out]`.
    #[inline(always)]
    pub(super) fn add_biases<S: Simd>(&self, simd: S, to: &mut [f32]) {
        for (panel, to) in to.chunks_mut(BLOCK).enumerate() {
            let n = S::f32s::LEN;
            for at in (0..BLOCK).step_by(n) {
                let mut sum = S::f32s::splat(simd, 0.0);
                for row in self.panel(panel).as_flattened() {
                    sum += S::f32s::from_slice(simd, &row[at..at + n]);
                }
                let sums = to.get_mut(at..).unwrap_or_default();
                for (to, sum) in sums.iter_mut().zip(sum.as_slice()) {
                    *to += sum;
                }
            }
        }
    }

    /// Adds to the gradient of the weights of the inputs `x`: `to` is `[n_in, n_out]`.
    #[inline(always)]
    pub(super) fn add_weights<S: Simd>(&self, simd: S, x: Blocks<'_>, to: &mut [f32]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let n = S::f32s::LEN;
                for (panel, first) in (0..self.n_out).step_by(BLOCK).enumerate() {
                    let columns = BLOCK.min(self.n_out - first);
                    for input in (0..x.per_block).step_by(INPUTS) {
                        let inputs = INPUTS.min(x.per_block - input);
                        let to = &mut to[input * self.n_out + first..];
                        let tiles = self.panel(panel);
                        if n == 16 && columns > 16 {
                            self.add_tile::<S, INPUTS, 2>(
                                simd,
                                tiles,
                                x,
                                [input, inputs],
                                to,
                                [0, columns],
                            );
                            continue;
                        }
                        // Sixteen registers hold half of that.
                        for at in (0..columns).step_by(n) {
                            let columns = [at, n.min(columns - at)];
                            self.add_tile::<S, INPUTS, 1>(
                                simd,
                                tiles,
                                x,
                                [input, inputs],
                                to,
                                columns,
                            );
                        }
                    }
                }
            },
        );
    }

    /// A register tile: inputs times `V` registers of outputs, over all samples.
    #[inline(always)]
    fn add_tile<S: Simd, const I: usize, const V: usize>(
        &self,
        simd: S,
        tiles: &[[Row; BLOCK]],
        x: Blocks<'_>,
        [input, inputs]: [usize; 2],
        to: &mut [f32],
        [at, columns]: [usize; 2],
    ) {
        let n = S::f32s::LEN;
        let zero = S::f32s::splat(simd, 0.0);
        let mut sums = [[zero; V]; I];
        for (tile, rows) in tiles.iter().zip(x.rows.chunks_exact(x.per_block)) {
            // A tile at the edge looks at its last input several times.
            let row = |i: usize| &rows[input + i.min(inputs - 1)];
            let rows: [&Row; I] = std::array::from_fn(row);
            for (s, outputs) in tile.iter().enumerate() {
                let mut values = [zero; V];
                for (v, value) in values.iter_mut().enumerate() {
                    *value = S::f32s::from_slice(simd, &outputs[at + v * n..at + (v + 1) * n]);
                }
                for (sums, row) in sums.iter_mut().zip(&rows) {
                    let x = S::f32s::splat(simd, row[s]);
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum = value.mul_add(x, *sum);
                    }
                }
            }
        }
        let mut all = [[0.0; BLOCK]; I];
        for (all, sums) in all.iter_mut().zip(&sums) {
            for (v, sum) in sums.iter().enumerate() {
                sum.store_slice(&mut all[v * n..(v + 1) * n]);
            }
        }
        for (to, all) in to.chunks_mut(self.n_out).zip(&all).take(inputs) {
            for (to, sum) in to[at..at + columns].iter_mut().zip(all) {
                *to += sum;
            }
        }
    }
}
