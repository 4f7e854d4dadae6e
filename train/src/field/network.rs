//! Networks backwards: from the gradient of the output to those of weights and
//! input. Rows are features, columns samples, as in core.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};
use pocketnerf_core::network::{Dense, dense};
use pocketnerf_core::{DType, Layout as Order, TensorView};

use super::layout::{Layout, Part, Role};
use crate::aligned::Aligned;

/// A network's layers as the backward pass reads them.
#[derive(Clone, Debug, Default)]
pub(super) struct Network {
    /// Widths from input to output.
    pub(super) widths: Vec<usize>,
    /// Offsets of each layer's weights and biases among the networks' parameters.
    offsets: Vec<[usize; 2]>,
    /// Each layer's weights transposed, `[n_out, n_in]`.
    transposed: Vec<Vec<f32>>,
}

impl Network {
    /// The network of this name in a layout.
    pub(super) fn new(layout: &Layout, name: &'static str, widths: Vec<usize>) -> Self {
        let start = layout.networks_start();
        let offset = |layer, role| layout.range(Part { network: name, layer, role }).start - start;
        let n_layers = widths.len() - 1;
        let offsets = (0..n_layers).map(|i| [Role::Weight, Role::Bias].map(|role| offset(i, role)));
        let transposed = widths.windows(2).map(|w| vec![0.0; w[0] * w[1]]);
        Self { offsets: offsets.collect(), transposed: transposed.collect(), widths }
    }

    /// Number of layers.
    pub(super) fn n_layers(&self) -> usize {
        self.offsets.len()
    }

    /// Takes over the weights in `networks`, the networks' parameters.
    pub(super) fn update(&mut self, networks: &[f32]) {
        for (i, transposed) in self.transposed.iter_mut().enumerate() {
            let (n_in, n_out) = (self.widths[i], self.widths[i + 1]);
            let weights = &networks[self.offsets[i][0]..][..n_in * n_out];
            for (o, row) in transposed.chunks_exact_mut(n_in).enumerate() {
                for (input, value) in row.iter_mut().enumerate() {
                    *value = weights[input * n_out + o];
                }
            }
        }
    }

    /// Computes every hidden layer of `n` points, `hidden[i]` being
    /// `[widths[i + 1]][stride]`, from `input`, and the output where wanted.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "slices of one batch, each with its own size")]
    pub(super) fn forward<S: Simd>(
        &self,
        simd: S,
        layers: &[Dense<'_>],
        input: &[f32],
        hidden: &mut [Aligned<f32>],
        output: Option<&mut [f32]>,
        n: usize,
        stride: usize,
        panel: &mut [f32],
    ) {
        let (last, before) = layers.split_last().expect("a network has layers");
        for (i, layer) in before.iter().enumerate() {
            let (done, next) = hidden.split_at_mut(i);
            let x = done.last().map_or(input, |v| &v[..]);
            dense(simd, layer, x, &mut next[0], n, stride, true, panel);
        }
        if let Some(output) = output {
            let x = hidden.last().map_or(input, |v| &v[..]);
            dense(simd, last, x, output, n, stride, false, panel);
        }
    }

    /// Backwards through all layers. `gradient` is `[n_out][stride]`; it and
    /// `other` have room for the widest layer and are overwritten. Weight
    /// gradients are added to `weights`, laid out like the networks'
    /// parameters. The gradient of the input goes to `d_input`,
    /// `[n_in][stride]`, where wanted.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "slices of one batch, each with its own size")]
    pub(super) fn backward<S: Simd>(
        &self,
        simd: S,
        input: &[f32],
        hidden: &[Aligned<f32>],
        [gradient, other]: [&mut Aligned<f32>; 2],
        n: usize,
        stride: usize,
        weights: &mut [f32],
        mut d_input: Option<&mut [f32]>,
        panel: &mut [f32],
    ) {
        for i in (0..self.n_layers()).rev() {
            let (n_in, n_out) = (self.widths[i], self.widths[i + 1]);
            let [weight, bias] = self.offsets[i];
            let x = if i == 0 { input } else { &hidden[i - 1][..] };
            add_bias_gradient(simd, gradient, &mut weights[bias..bias + n_out], n, stride);
            let to = &mut weights[weight..weight + n_in * n_out];
            add_weight_gradient(simd, x, gradient, to, n_out, n, stride);
            if i > 0 {
                let transposed = self.transposed(i);
                dense(simd, &transposed, gradient, other, n, stride, false, panel);
                mask(simd, x, other, n_in, n, stride);
                std::mem::swap(gradient, other);
            } else if let Some(d_input) = &mut d_input {
                let transposed = self.transposed(0);
                dense(simd, &transposed, gradient, d_input, n, stride, false, panel);
            }
        }
    }

    fn transposed(&self, i: usize) -> Dense<'_> {
        let shape = [self.widths[i + 1] as u32, self.widths[i] as u32];
        let bytes = bytemuck::must_cast_slice(&self.transposed[i]);
        let weight = TensorView::new(bytes, DType::F32, shape, 0, Order::RowMajor)
            .expect("the length is the product of the shape");
        Dense { weight, bias: None }
    }
}

/// Where ReLU gave 0, nothing flows back.
#[inline(always)]
fn mask<S: Simd>(
    simd: S,
    hidden: &[f32],
    gradient: &mut [f32],
    rows: usize,
    n: usize,
    stride: usize,
) {
    let zero = S::f32s::splat(simd, 0.0);
    for (hidden, gradient) in hidden.chunks(stride).zip(gradient.chunks_mut(stride)).take(rows) {
        let lanes = S::f32s::LEN;
        let pairs = hidden[..n].chunks_exact(lanes).zip(gradient[..n].chunks_exact_mut(lanes));
        for (h, g) in pairs {
            let open = S::f32s::from_slice(simd, h).simd_gt(zero);
            open.select(S::f32s::from_slice(simd, g), zero).store_slice(g);
        }
    }
}

#[inline(always)]
fn add_bias_gradient<S: Simd>(simd: S, gradient: &[f32], to: &mut [f32], n: usize, stride: usize) {
    for (row, to) in gradient.chunks(stride).zip(to) {
        let mut sum = S::f32s::splat(simd, 0.0);
        for values in row[..n].chunks_exact(S::f32s::LEN) {
            sum += S::f32s::from_slice(simd, values);
        }
        *to += sum.reduce_sum();
    }
}

/// `to[i][o] += sum over s of x[i][s] * gradient[o][s]`.
#[inline(always)]
fn add_weight_gradient<S: Simd>(
    simd: S,
    x: &[f32],
    gradient: &[f32],
    to: &mut [f32],
    n_out: usize,
    n: usize,
    stride: usize,
) {
    const TILE: usize = 4;
    simd.vectorize(
        #[inline(always)]
        || {
            for (block, to) in to.chunks_mut(TILE * n_out).enumerate() {
                let first = block * TILE;
                let rows = to.len() / n_out;
                for o in (0..n_out).step_by(TILE) {
                    let columns = TILE.min(n_out - o);
                    if rows == TILE && columns == TILE {
                        let x = &x[first * stride..];
                        add_tile::<S, TILE, TILE>(
                            simd,
                            x,
                            &gradient[o * stride..],
                            &mut to[o..],
                            n_out,
                            n,
                            stride,
                        );
                    } else {
                        for (i, to) in to.chunks_mut(n_out).enumerate() {
                            let x = &x[(first + i) * stride..];
                            for o in o..o + columns {
                                let g = &gradient[o * stride..];
                                add_tile::<S, 1, 1>(simd, x, g, &mut to[o..], n_out, n, stride);
                            }
                        }
                    }
                }
            }
        },
    );
}

/// One register tile of [`add_weight_gradient`].
#[inline(always)]
fn add_tile<S: Simd, const A: usize, const B: usize>(
    simd: S,
    x: &[f32],
    gradient: &[f32],
    to: &mut [f32],
    n_out: usize,
    n: usize,
    stride: usize,
) {
    let lanes = S::f32s::LEN;
    let zero = S::f32s::splat(simd, 0.0);
    let mut sums = [[zero; B]; A];
    for at in (0..n).step_by(lanes) {
        let mut g = [zero; B];
        for (o, value) in g.iter_mut().enumerate() {
            *value = S::f32s::from_slice(simd, &gradient[o * stride + at..][..lanes]);
        }
        for (i, sums) in sums.iter_mut().enumerate() {
            let x = S::f32s::from_slice(simd, &x[i * stride + at..][..lanes]);
            for (sum, g) in sums.iter_mut().zip(g) {
                *sum = x.mul_add(g, *sum);
            }
        }
    }
    for (i, sums) in sums.iter().enumerate() {
        for (o, sum) in sums.iter().enumerate() {
            to[i * n_out + o] += sum.reduce_sum();
        }
    }
}
