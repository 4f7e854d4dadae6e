//! Both networks backwards: from the gradient of densities, features and colours to
//! that of encoded points and network weights.

use fearless_simd::{Simd, SimdBase};
use pocketnerf_core::field::Decoder;
use pocketnerf_core::lanes;
use pocketnerf_core::network::panel_len;

use super::Encoding;
use super::config::{COLOR, DENSITY, EncodedFieldConfig};
use crate::aligned::Aligned;
use crate::field::Layout;
use crate::field::network::Network;

/// The networks of a field, ready to go backwards.
#[derive(Clone, Debug)]
pub(super) struct Networks {
    density: Network,
    color: Network,
    pub(super) max_width: usize,
}

/// Buffers of one worker for a batch of points.
#[derive(Clone, Debug)]
pub(super) struct Gradients {
    stride: usize,
    density_hidden: Vec<Aligned<f32>>,
    color_hidden: Vec<Aligned<f32>>,
    gradient: Aligned<f32>,
    other: Aligned<f32>,
    panel: Aligned<f32>,
}

impl Gradients {
    /// The buffer that holds a gradient, `[max width][stride]`, the width rounded
    /// up to a multiple of 16.
    pub(super) fn rows(&mut self) -> &mut [f32] {
        &mut self.gradient
    }
}

impl Networks {
    /// For fields of this shape.
    pub(super) fn new<E: Encoding>(config: &EncodedFieldConfig<E>, layout: &Layout) -> Self {
        let density = Network::new(layout, DENSITY, config.density_widths());
        let color = Network::new(layout, COLOR, config.color_widths());
        let max_width = density.widths.iter().chain(&color.widths).copied().max().unwrap_or(0);
        Self { density, color, max_width }
    }

    /// Takes over new weights: the networks' part of the parameters.
    pub(super) fn update(&mut self, networks: &[f32]) {
        self.density.update(networks);
        self.color.update(networks);
    }

    /// Buffers for batches of up to `stride` points.
    pub(super) fn buffers(&self, stride: usize) -> Gradients {
        let hidden = |network: &Network| {
            let widths = network.widths.iter().take(network.n_layers()).skip(1);
            widths.map(|w| Aligned::new(w * stride)).collect()
        };
        Gradients {
            stride,
            density_hidden: hidden(&self.density),
            color_hidden: hidden(&self.color),
            gradient: Aligned::new(self.max_width.next_multiple_of(16) * stride),
            other: Aligned::new(self.max_width.next_multiple_of(16) * stride),
            panel: Aligned::new(panel_len(self.max_width)),
        }
    }

    /// Density network forwards over `encoded`, as [`Networks::density`] needs
    /// it; its `[1 + n_features][stride]` outputs go to `output` where wanted.
    #[inline(always)]
    pub(super) fn density_forward<S: Simd>(
        &self,
        simd: S,
        decoder: &Decoder<'_>,
        encoded: &[f32],
        buffers: &mut Gradients,
        n: usize,
        output: Option<&mut [f32]>,
    ) {
        let Gradients { stride, density_hidden: hidden, panel, .. } = buffers;
        let layers = decoder.density.layers();
        self.density.forward(simd, layers, encoded, hidden, output, n, *stride, panel);
    }

    /// Density network backwards, after [`Networks::density_forward`].
    /// `buffers.rows()` holds the gradient of its outputs,
    /// `[1 + n_features][stride]`; `encoded` its inputs; `n` points, a multiple of
    /// 32. Adds to `weights`; the inputs' gradient goes to `d_encoded` where
    /// wanted.
    #[inline(always)]
    pub(super) fn density<S: Simd>(
        &self,
        simd: S,
        encoded: &[f32],
        buffers: &mut Gradients,
        n: usize,
        weights: &mut [f32],
        d_encoded: Option<&mut [f32]>,
    ) {
        let Gradients { stride, density_hidden: hidden, gradient, other, panel, .. } = buffers;
        let pair = [gradient, other];
        self.density.backward(simd, encoded, hidden, pair, n, *stride, weights, d_encoded, panel);
    }

    /// Colour network forwards over `input`, `[features, harmonics][stride]`, as
    /// [`Networks::color`] needs it: colours in [0, 1] go to `rgb`, `[3][stride]`.
    #[inline(always)]
    pub(super) fn color_forward<S: Simd>(
        &self,
        simd: S,
        decoder: &Decoder<'_>,
        input: &[f32],
        buffers: &mut Gradients,
        n: usize,
        rgb: &mut [f32],
    ) {
        let Gradients { stride, color_hidden: hidden, panel, .. } = buffers;
        let (layers, output) = (decoder.color.layers(), Some(&mut *rgb));
        self.color.forward(simd, layers, input, hidden, output, n, *stride, panel);
        for row in rgb.chunks_mut(*stride).take(3) {
            for values in row[..n].chunks_exact_mut(S::f32s::LEN) {
                lanes::logistic(simd, S::f32s::from_slice(simd, values)).store_slice(values);
            }
        }
    }

    /// Colour network backwards, after [`Networks::color_forward`].
    /// `buffers.rows()` holds the gradient of its outputs before the logistic,
    /// `[3][stride]`. Afterwards `d_input` holds the inputs' gradient.
    #[inline(always)]
    pub(super) fn color<S: Simd>(
        &self,
        simd: S,
        input: &[f32],
        buffers: &mut Gradients,
        n: usize,
        weights: &mut [f32],
        d_input: &mut [f32],
    ) {
        let Gradients { stride, color_hidden: hidden, gradient, other, panel, .. } = buffers;
        let pair = [gradient, other];
        self.color.backward(simd, input, hidden, pair, n, *stride, weights, Some(d_input), panel);
    }
}
