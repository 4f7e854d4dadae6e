//! Dense layers over samples in blocks of 32: for wide networks.
//!
//! The rows of a block lie one after another, so that a layer's 256 inputs are one
//! stretch of memory, 32 kB long, which the processor fetches ahead; rows of a whole
//! batch would lie on a page each. A panel of eight outputs' weights is decoded once
//! for all blocks.

use fearless_simd::{Simd, SimdBase, SimdFloat};

use super::{Dense, PANEL, finish_row, load_bias, load_panel, panel_len};
use crate::DType;
use crate::store::{F16, F32, Store};

/// Samples in a block.
pub const BLOCK: usize = 32;

/// Half the outputs of a panel.
const HALF: usize = PANEL / 2;

/// A value of each sample of a block.
pub type Row = [f32; BLOCK];

/// Values of samples in blocks: `[block][per_block]` rows.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'x> {
    /// The rows.
    pub rows: &'x [Row],
    /// Rows of a block.
    pub per_block: usize,
}

impl Blocks<'_> {
    /// No values.
    pub const NONE: Blocks<'static> = Blocks { rows: &[], per_block: 0 };

    /// The rows of block `b`.
    #[inline(always)]
    fn block(&self, b: usize) -> &[Row] {
        &self.rows[b * self.per_block..][..self.per_block]
    }
}

/// Applies one layer to blocks of samples: `y = W x + b`, then ReLU where `relu` (NaN
/// passes, as in [`dense`](super::dense)). The layer reads the values of both `x`, one
/// after the other; `y` is `[block][n_out]`, and its length says how many blocks there
/// are. `panel` holds at least [`panel_len`] values.
pub fn dense_blocks<S: Simd>(
    simd: S,
    layer: &Dense<'_>,
    x: [Blocks<'_>; 2],
    y: &mut [Row],
    relu: bool,
    panel: &mut [f32],
) {
    match layer.weight.dtype() {
        DType::F32 => dense_blocks_stored::<S, F32>(simd, layer, x, y, relu, panel),
        // Layers are stored in no other type.
        DType::F16 | DType::I8 | DType::U16 => {
            dense_blocks_stored::<S, F16>(simd, layer, x, y, relu, panel);
        }
    }
}

fn dense_blocks_stored<S: Simd, T: Store>(
    simd: S,
    layer: &Dense<'_>,
    x: [Blocks<'_>; 2],
    y: &mut [Row],
    relu: bool,
    panel: &mut [f32],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (n_in, n_out) = (layer.weight.rows(), layer.weight.cols());
            let panel = &mut panel[..panel_len(n_in)];
            for first in (0..n_out).step_by(PANEL) {
                let width = PANEL.min(n_out - first);
                load_panel::<S, T>(simd, &layer.weight, (first, width), panel);
                let bias = load_bias::<T>(layer, first, width);
                let panels = panel.as_chunks::<PANEL>().0.split_at(x[0].per_block);
                for (b, y) in y.chunks_exact_mut(n_out).enumerate() {
                    let (rows, y) = ([x[0].block(b), x[1].block(b)], &mut y[first..first + width]);
                    let n = S::f32s::LEN;
                    match n {
                        // With 32 registers, sixteen sums hide the latency of the additions.
                        16 => multiply::<S, 0, PANEL, 2>(simd, panels, &bias, rows, y, 0, relu),
                        // With 16, eight just do; half a panel at two registers of
                        // samples loads six values for them, a panel at one nine.
                        8 => {
                            for at in (0..BLOCK).step_by(2 * n) {
                                multiply::<S, 0, HALF, 2>(simd, panels, &bias, rows, y, at, relu);
                                if width > HALF {
                                    multiply::<S, HALF, HALF, 2>(
                                        simd, panels, &bias, rows, y, at, relu,
                                    );
                                }
                            }
                        }
                        _ => {
                            for at in (0..BLOCK).step_by(n) {
                                multiply::<S, 0, PANEL, 1>(simd, panels, &bias, rows, y, at, relu);
                            }
                        }
                    }
                }
            }
        },
    );
}

/// The `O` outputs from `FROM` on of a panel, as far as there are rows for them, at `V`
/// registers of samples from `at` on.
#[inline(always)]
fn multiply<S: Simd, const FROM: usize, const O: usize, const V: usize>(
    simd: S,
    (first, second): (&[[f32; PANEL]], &[[f32; PANEL]]),
    bias: &[f32; PANEL],
    x: [&[Row]; 2],
    y: &mut [Row],
    at: usize,
    relu: bool,
) {
    let mut sums = [[S::f32s::splat(simd, 0.0); V]; O];
    for (sums, b) in sums.iter_mut().zip(&bias[FROM..]) {
        *sums = [S::f32s::splat(simd, *b); V];
    }
    add_products::<S, FROM, O, V>(simd, &mut sums, first, x[0], at);
    add_products::<S, FROM, O, V>(simd, &mut sums, second, x[1], at);
    let (n, y) = (S::f32s::LEN, y.get_mut(FROM..).unwrap_or_default());
    if let Some(y) = y.first_chunk_mut::<O>() {
        // Unrolled, so that the sums stay in registers.
        for (sums, y) in sums.iter().zip(y) {
            finish_row(simd, sums, &mut y[at..at + V * n], relu);
        }
    } else {
        for (sums, y) in sums.iter().zip(y) {
            finish_row(simd, sums, &mut y[at..at + V * n], relu);
        }
    }
}

#[inline(always)]
fn add_products<S: Simd, const FROM: usize, const O: usize, const V: usize>(
    simd: S,
    sums: &mut [[S::f32s; V]; O],
    panel: &[[f32; PANEL]],
    x: &[Row],
    at: usize,
) {
    let n = S::f32s::LEN;
    for (weights, row) in panel.iter().zip(x) {
        let mut values = [S::f32s::splat(simd, 0.0); V];
        for (v, value) in values.iter_mut().enumerate() {
            *value = S::f32s::from_slice(simd, &row[at + v * n..at + (v + 1) * n]);
        }
        for (sums, weight) in sums.iter_mut().zip(&weights[FROM..]) {
            let weight = S::f32s::splat(simd, *weight);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum = value.mul_add(weight, *sum);
            }
        }
    }
}
