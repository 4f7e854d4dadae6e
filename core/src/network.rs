//! Small dense networks: layers with ReLU between them and none after the last.

pub mod blocks;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod pairs;

use core::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use crate::store::{F16, F32, Store};
use crate::{DType, Error, TensorView};

/// Most layers a network may have.
pub const MAX_LAYERS: usize = 10;

/// `y = W x + b`.
#[derive(Clone, Copy, Debug)]
pub struct Dense<'a> {
    /// `[n_in, n_out]`: input-major, so that the outputs of one input lie together.
    pub weight: TensorView<'a>,
    /// `[1, n_out]`; `None`: no bias.
    pub bias: Option<TensorView<'a>>,
}

impl Dense<'_> {
    /// The placeholder in fixed-size arrays.
    pub const EMPTY: Dense<'static> = Dense { weight: TensorView::EMPTY, bias: None };

    /// Checks a layer of a network whose layers are stored as `dtype`.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self, dtype: DType) -> Result<(), Error> {
        let [n_in, n_out] = self.weight.shape();
        if n_in == 0 || n_out == 0 || n_in > 4096 || n_out > 4096 {
            return Err(Error::Range("network: width of a layer"));
        }
        if matches!(self.weight.dtype(), DType::I8 | DType::U16) {
            return Err(Error::Shape("network: weights of whole numbers"));
        }
        if self.weight.dtype() != dtype {
            return Err(Error::Shape("network: layers of different types"));
        }
        if let Some(bias) = self.bias
            && (bias.shape() != [1, n_out] || bias.dtype() != dtype)
        {
            return Err(Error::Shape("network: a bias and its layer"));
        }
        Ok(())
    }
}

/// A network of dense layers.
#[derive(Clone, Copy, Debug)]
pub struct Mlp<'a> {
    layers: [Dense<'a>; MAX_LAYERS],
    n_layers: usize,
}

impl<'a> Mlp<'a> {
    /// Checks that the layers fit onto one another.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn new(layers: &[Dense<'a>]) -> Result<Self, Error> {
        if layers.is_empty() || layers.len() > MAX_LAYERS {
            return Err(Error::Range("network: number of layers"));
        }
        for layer in layers {
            layer.validate(layers[0].weight.dtype())?;
        }
        for pair in layers.windows(2) {
            if pair[0].weight.cols() != pair[1].weight.rows() {
                return Err(Error::Shape("network: a layer and the next"));
            }
        }
        let mut all = [Dense::EMPTY; MAX_LAYERS];
        all[..layers.len()].copy_from_slice(layers);
        Ok(Self { layers: all, n_layers: layers.len() })
    }

    /// The layers, first to last.
    #[must_use]
    pub fn layers(&self) -> &[Dense<'a>] {
        &self.layers[..self.n_layers]
    }

    /// Values read.
    #[must_use]
    pub fn n_input(&self) -> usize {
        self.layers[0].weight.rows()
    }

    /// Values given.
    #[must_use]
    pub fn n_output(&self) -> usize {
        self.layers[self.n_layers - 1].weight.cols()
    }

    /// The widest layer's width, inputs and outputs included.
    #[must_use]
    pub fn max_width(&self) -> usize {
        self.layers().iter().map(|l| l.weight.rows().max(l.weight.cols())).max().unwrap_or(0)
    }
}

/// Outputs that a kernel computes at a time.
const PANEL: usize = 8;

/// Values of scratch that [`dense`] needs for a layer of `n_in` inputs.
#[must_use]
pub const fn panel_len(n_in: usize) -> usize {
    n_in * PANEL
}

/// Applies one layer to `n` points: `y = W x + b`, then ReLU where `relu`. NaN
/// passes ReLU, on every machine: a density that is no number ends as empty
/// space, a colour that is none as black.
///
/// `x` is `[n_in][stride]`, `y` is `[n_out][stride]`; `n` is a multiple of 16
/// and at most `stride`. `panel` holds at least [`panel_len`]`(n_in)` values.
#[expect(clippy::too_many_arguments, reason = "a batch is its slices and their lengths")]
pub fn dense<S: Simd>(
    simd: S,
    layer: &Dense<'_>,
    x: &[f32],
    y: &mut [f32],
    n: usize,
    stride: usize,
    relu: bool,
    panel: &mut [f32],
) {
    match layer.weight.dtype() {
        DType::F32 => dense_stored::<S, F32>(simd, layer, x, y, n, stride, relu, panel),
        // Layers are stored in no other type.
        DType::F16 | DType::I8 | DType::U16 => {
            dense_stored::<S, F16>(simd, layer, x, y, n, stride, relu, panel);
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "as for `dense`")]
fn dense_stored<S: Simd, T: Store>(
    simd: S,
    layer: &Dense<'_>,
    x: &[f32],
    y: &mut [f32],
    n: usize,
    stride: usize,
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
                let rows = &mut y[first * stride..];
                // With 32 registers, sixteen sums hide the latency of the additions.
                let pairs = if S::f32s::LEN == 16 { n - n % 32 } else { 0 };
                let (x, bias) = ((x, stride), (&bias, width));
                multiply_panel::<S, 2>(simd, panel, bias, x, rows, 0..pairs, relu);
                multiply_panel::<S, 1>(simd, panel, bias, x, rows, pairs..n, relu);
            }
        },
    );
}

/// Decodes the biases `first .. first + width`, zero-filled.
#[inline(always)]
fn load_bias<T: Store>(layer: &Dense<'_>, first: usize, width: usize) -> [f32; PANEL] {
    let mut bias = [0.0; PANEL];
    if let Some(b) = &layer.bias {
        let values = &T::values(b.bytes())[first..first + width];
        for (to, from) in bias.iter_mut().zip(values) {
            *to = T::decode(*from) * b.scale();
        }
    }
    bias
}

/// Decodes the columns `first .. first + width` of a weight matrix to
/// `[n_in][PANEL]`, zero-filled.
#[inline(always)]
fn load_panel<S: Simd, T: Store>(
    simd: S,
    weight: &TensorView<'_>,
    (first, width): (usize, usize),
    panel: &mut [f32],
) {
    let factor = T::FACTOR * weight.scale();
    let rows = T::values(weight.bytes()).chunks_exact(weight.cols());
    for (row, to) in rows.zip(panel.as_chunks_mut::<PANEL>().0) {
        let from = &row[first..first + width];
        if let Ok(from) = from.try_into() {
            *to = T::decode_eight(simd, from).map(|value| value * factor);
        } else {
            *to = [0.0; PANEL];
            for (to, from) in to.iter_mut().zip(from) {
                *to = T::decode_divided(*from) * factor;
            }
        }
    }
}

/// The first `width` outputs of a panel at `points`, `V` registers at a time.
#[inline(always)]
fn multiply_panel<S: Simd, const V: usize>(
    simd: S,
    panel: &[f32],
    (bias, width): (&[f32; PANEL], usize),
    (x, stride): (&[f32], usize),
    y: &mut [f32],
    points: Range<usize>,
    relu: bool,
) {
    let lanes = S::f32s::LEN;
    let zero = S::f32s::splat(simd, 0.0);
    for at in points.step_by(V * lanes) {
        let mut sums = [[zero; V]; PANEL];
        for (sums, b) in sums.iter_mut().zip(bias) {
            *sums = [S::f32s::splat(simd, *b); V];
        }
        for (weights, row) in panel.as_chunks::<PANEL>().0.iter().zip(x.chunks(stride)) {
            let row = &row[at..at + V * lanes];
            let mut values = [zero; V];
            for (v, value) in values.iter_mut().enumerate() {
                *value = S::f32s::from_slice(simd, &row[v * lanes..(v + 1) * lanes]);
            }
            for (sums, weight) in sums.iter_mut().zip(weights) {
                let weight = S::f32s::splat(simd, *weight);
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum = value.mul_add(weight, *sum);
                }
            }
        }
        // A whole panel's loop is unrolled, so that sums stay in wide registers.
        if width == PANEL && lanes > 4 {
            for (o, sums) in sums.iter().enumerate() {
                finish_row(simd, sums, &mut y[o * stride + at..][..V * lanes], relu);
            }
        } else {
            for (o, sums) in sums.iter().enumerate().take(width) {
                finish_row(simd, sums, &mut y[o * stride + at..][..V * lanes], relu);
            }
        }
    }
}

/// Writes an output's sums.
#[inline(always)]
fn finish_row<S: Simd, const V: usize>(simd: S, sums: &[S::f32s; V], row: &mut [f32], relu: bool) {
    let (lanes, zero) = (S::f32s::LEN, S::f32s::splat(simd, 0.0));
    for (v, sum) in sums.iter().enumerate() {
        // Not `max`, which takes NaN to 0 on some machines and not on others.
        let value = if relu { sum.simd_lt(zero).select(zero, *sum) } else { *sum };
        value.store_slice(&mut row[v * lanes..(v + 1) * lanes]);
    }
}

impl Mlp<'_> {
    /// Applies all layers to `n` points (a multiple of 16, at most `stride`).
    ///
    /// `input` is `[n_input][stride]` and is overwritten, also by every second hidden
    /// layer, `other` is scratch for the layers between; the result goes to
    /// `output`, `[n_output][stride]`. Where `rounded`, values may be rounded to 14 bits of a
    /// point's largest, which is faster on x86: outputs change by about a ten-thousandth.
    #[expect(clippy::too_many_arguments, reason = "a batch is its slices and their lengths")]
    pub fn forward<S: Simd>(
        &self,
        simd: S,
        input: &mut [f32],
        other: &mut [f32],
        output: &mut [f32],
        n: usize,
        stride: usize,
        panel: &mut [f32],
        rounded: bool,
    ) {
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let _ = rounded;
        let mut apply = |layer: &Dense<'_>, x: &mut [f32], y: &mut [f32], relu: bool| {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            if rounded && pairs::suit(layer) {
                let level = simd.level();
                if let Some(avx512) = level.as_avx512() {
                    return pairs::dense(avx512, layer, x, y, n, stride, relu, panel);
                }
                if let Some(avx2) = level.as_avx2() {
                    return pairs::dense(avx2, layer, x, y, n, stride, relu, panel);
                }
            }
            dense(simd, layer, x, y, n, stride, relu, panel);
        };
        let (mut from, mut to) = (input, other);
        let last = self.n_layers - 1;
        for layer in &self.layers[..last] {
            apply(layer, from, to, true);
            core::mem::swap(&mut from, &mut to);
        }
        apply(&self.layers[last], from, output, false);
    }
}

#[cfg(test)]
mod tests;
