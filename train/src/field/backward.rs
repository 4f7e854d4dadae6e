//! A field backwards: from the gradient of densities, features and colours to
//! that of encoded points and network weights.

use fearless_simd::{Simd, SimdBase};
use pocketnerf_core::field::Decoder;
use pocketnerf_core::lanes;
use pocketnerf_core::network::panel_len;

use super::network::Network;
use super::{EncodingConfig, FieldConfig, Layout, NerfGradients};
use crate::aligned::Aligned;

/// The networks of a field, ready to go backwards: those of a decoder, or the paper's.
#[derive(Clone, Debug)]
pub struct Backward {
    density: Network,
    color: Network,
    max_width: usize,
    nerf: Option<NerfGradients>,
}

/// Buffers of one worker for a batch of points.
#[derive(Clone, Debug)]
pub struct Gradients {
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
    pub fn rows(&mut self) -> &mut [f32] {
        &mut self.gradient
    }
}

impl Backward {
    /// For fields of this shape.
    #[must_use]
    pub fn new(config: &FieldConfig, layout: &Layout) -> Self {
        if let EncodingConfig::Nerf(nerf) = &config.encoding {
            let nerf = Some(NerfGradients::new(nerf, layout));
            let none = Network::default();
            return Self { density: none.clone(), color: none, max_width: 0, nerf };
        }
        let density = Network::new(layout, config.density_widths(), false);
        let color = Network::new(layout, config.color_widths(), true);
        let widths = density.widths.iter().chain(&color.widths);
        let max_width = widths.copied().max().unwrap_or(0);
        Self { density, color, max_width, nerf: None }
    }

    /// The paper's networks.
    pub(crate) fn nerf(&self) -> Option<&NerfGradients> {
        self.nerf.as_ref()
    }

    /// Takes over new weights: the networks' part of the parameters.
    pub fn update(&mut self, networks: &[f32]) {
        if let Some(nerf) = &mut self.nerf {
            nerf.update(networks);
            return;
        }
        self.density.update(networks);
        self.color.update(networks);
    }

    /// Buffers for batches of up to `stride` points.
    #[must_use]
    pub fn buffers(&self, stride: usize) -> Gradients {
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

    /// Density network forwards over `encoded`, as [`Backward::density`] needs
    /// it; its `[1 + n_features][stride]` outputs go to `output` where wanted.
    #[inline(always)]
    pub fn density_forward<S: Simd>(
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

    /// Density network backwards, after [`Backward::density_forward`].
    /// `buffers.rows()` holds the gradient of its outputs,
    /// `[1 + n_features][stride]`; `encoded` its inputs; `n` points, a multiple of
    /// 32. Adds to `weights`; the inputs' gradient goes to `d_encoded` where
    /// wanted.
    #[inline(always)]
    pub fn density<S: Simd>(
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
    /// [`Backward::color`] needs it: colours in [0, 1] go to `rgb`, `[3][stride]`.
    #[inline(always)]
    pub fn color_forward<S: Simd>(
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

    /// Colour network backwards, after [`Backward::color_forward`].
    /// `buffers.rows()` holds the gradient of its outputs before the logistic,
    /// `[3][stride]`. Afterwards `d_input` holds the inputs' gradient.
    #[inline(always)]
    pub fn color<S: Simd>(
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
