//! Backwards through the network.

use fearless_simd::{Select, Simd, SimdBase};
use pocketnerf_core::field::Activation;
use pocketnerf_core::math;
use pocketnerf_core::network::blocks::{BLOCK, Blocks, Row, dense_blocks};
use pocketnerf_core::network::{Dense, panel_len};
use pocketnerf_core::{DType, Layout as Order, TensorView};

use super::tape::NerfTape;
use super::weights::Transposed;
use super::{NerfConfig, NerfLayer};
use crate::aligned::Aligned;
use crate::field::{Layout, Role};

/// Where a layer's weights and biases begin among the parameters.
#[derive(Clone, Copy, Debug)]
struct Offsets {
    layer: NerfLayer,
    weight: usize,
    bias: usize,
}

/// Weights of a layer as the way back reads them, `[outputs, inputs]`.
#[derive(Clone, Debug)]
struct Back {
    weights: Vec<f32>,
    n_out: usize,
}

impl Back {
    fn new(n_out: usize, n_in: usize) -> Self {
        Self { weights: vec![0.0; n_out * n_in], n_out }
    }

    /// Takes over the weights of a layer, `[.., columns]`, from row `first` on, as rows
    /// `row` and after of this.
    fn set(&mut self, weights: &[f32], columns: usize, first: usize, row: usize) {
        let n_in = self.weights.len() / self.n_out;
        let rows = self.weights[row * n_in..].chunks_exact_mut(n_in);
        for (o, to) in rows.take(columns).enumerate() {
            for (i, value) in to.iter_mut().enumerate() {
                *value = weights[(first + i) * columns + o];
            }
        }
    }

    /// From the gradient of what layers gave to that of what they read.
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, x: [Blocks<'_>; 2], y: &mut [Row], panel: &mut [f32]) {
        dense_blocks(simd, &self.dense(), x, y, false, panel);
    }

    fn dense(&self) -> Dense<'_> {
        let shape = [self.n_out as u32, (self.weights.len() / self.n_out) as u32];
        let bytes = bytemuck::must_cast_slice(&self.weights);
        let weight = TensorView::new(bytes, DType::F32, shape, 0, Order::RowMajor)
            .expect("the length is the product of the shape");
        Dense { weight, bias: None }
    }
}

/// One network, ready to go backwards.
#[derive(Clone, Debug)]
struct Network {
    offsets: Vec<Offsets>,
    /// Of the trunk's layers after the first, what they read of the layer before.
    trunk: Vec<Back>,
    /// Feature (or the colour network's first layer), then density: all that reads the
    /// trunk.
    heads: Back,
    /// The colour network's first layer, what it reads of the feature.
    color: Back,
    rgb: Back,
}

impl Network {
    fn new(config: &NerfConfig, layout: &Layout, coarse: bool) -> Self {
        let offsets = config.layers().map(|layer| {
            let start = |role| layout.range(layer.part(coarse, role)).start;
            Offsets { layer, weight: start(Role::Weight), bias: start(Role::Bias) }
        });
        let (width, color) = (config.width, config.color_width);
        let read = if config.directions.is_some() { width } else { color };
        Self {
            offsets: offsets.collect(),
            trunk: (1..config.depth).map(|_| Back::new(width, width)).collect(),
            heads: Back::new(read + 1, width),
            color: Back::new(color, width),
            rgb: Back::new(3, color),
        }
    }

    fn update(&mut self, config: &NerfConfig, parameters: &[f32]) {
        let width = config.width;
        for offsets in &self.offsets {
            let [n_in, n_out] = config.shape(offsets.layer);
            let weights = &parameters[offsets.weight..][..n_in * n_out];
            match offsets.layer {
                NerfLayer::Trunk(0) => {}
                NerfLayer::Trunk(i) => self.trunk[i - 1].set(weights, n_out, n_in - width, 0),
                NerfLayer::Density => {
                    let last = self.heads.n_out - 1;
                    self.heads.set(weights, 1, 0, last);
                }
                NerfLayer::Feature => self.heads.set(weights, n_out, 0, 0),
                NerfLayer::Color(0) if config.directions.is_none() => {
                    self.heads.set(weights, n_out, 0, 0);
                }
                NerfLayer::Color(0) => self.color.set(weights, n_out, 0, 0),
                NerfLayer::Color(_) => self.rgb.set(weights, n_out, 0, 0),
            }
        }
    }
}

/// The networks, ready to go backwards.
#[derive(Clone, Debug)]
pub(in crate::field) struct NerfGradients {
    config: NerfConfig,
    /// Fine, then coarse where there is one.
    networks: Vec<Network>,
}

/// Buffers of one worker.
#[derive(Debug)]
pub(in crate::field) struct NerfWork {
    a: Aligned<f32>,
    b: Aligned<f32>,
    color: Aligned<f32>,
    transposed: Transposed,
    panel: Aligned<f32>,
}

impl NerfGradients {
    /// For fields of this shape.
    pub(in crate::field) fn new(config: &NerfConfig, layout: &Layout) -> Self {
        let nets = [false, true].into_iter().take(1 + usize::from(config.coarse));
        let networks = nets.map(|coarse| Network::new(config, layout, coarse)).collect();
        Self { config: *config, networks }
    }

    /// The shape.
    pub(in crate::field) fn config(&self) -> &NerfConfig {
        &self.config
    }

    /// Takes over new weights.
    pub(in crate::field) fn update(&mut self, parameters: &[f32]) {
        for network in &mut self.networks {
            network.update(&self.config, parameters);
        }
    }

    /// Buffers for so many samples at most.
    pub(in crate::field) fn work(&self, samples: usize) -> NerfWork {
        let blocks = samples.div_ceil(BLOCK);
        let (width, color) = (self.config.width, self.config.color_width);
        let rows = |n: usize| Aligned::new(n * blocks * BLOCK);
        NerfWork {
            a: rows(width),
            b: rows(width),
            color: rows(color),
            transposed: Transposed::new(width.max(color), blocks),
            panel: Aligned::new(panel_len(width.max(color) + 1)),
        }
    }

    /// Backwards through what `tape` holds of the fine or the coarse network, whose
    /// gradients have been set there. Adds to `gradient`, laid out as the parameters.
    #[inline(always)]
    pub(in crate::field) fn backward<S: Simd>(
        &self,
        simd: S,
        coarse: bool,
        tape: &NerfTape,
        work: &mut NerfWork,
        gradient: &mut [f32],
    ) {
        let (config, network) = (&self.config, &self.networks[usize::from(coarse)]);
        let n = tape.n_blocks();
        let width = config.width;
        let NerfWork { a, b, color, transposed, panel } = work;
        let mut own = Own { network, transposed, gradient };
        let Some(trunk) = tape.trunk.last().map(|rows| rows.blocks(n)) else { return };
        let (rgb, density) = (tape.rgb.blocks(n), tape.density.blocks(n));
        own.add(simd, NerfLayer::Color(1), rgb, [tape.color.blocks(n), Blocks::NONE]);
        let color = rows(color, config.color_width, n);
        network.rgb.apply(simd, [rgb, Blocks::NONE], color, panel);
        mask(simd, tape.color.blocks(n), color);
        let color = Blocks { rows: color, per_block: config.color_width };
        let d_trunk = rows(b, width, n);
        if config.directions.is_some() {
            let x = [tape.feature.blocks(n), tape.directions.blocks(n)];
            own.add(simd, NerfLayer::Color(0), color, x);
            let d_feature = rows(a, width, n);
            network.color.apply(simd, [color, Blocks::NONE], d_feature, panel);
            let d_feature = Blocks { rows: d_feature, per_block: width };
            own.add(simd, NerfLayer::Feature, d_feature, [trunk, Blocks::NONE]);
            network.heads.apply(simd, [d_feature, density], d_trunk, panel);
        } else {
            own.add(simd, NerfLayer::Color(0), color, [trunk, Blocks::NONE]);
            network.heads.apply(simd, [color, density], d_trunk, panel);
        }
        own.add(simd, NerfLayer::Density, density, [trunk, Blocks::NONE]);
        mask(simd, trunk, d_trunk);
        for i in (0..config.depth).rev() {
            let outputs = Blocks { rows: rows(b, width, n), per_block: width };
            let encoded = tape.encoded.blocks(n);
            let Some(before) = i.checked_sub(1).map(|i| tape.trunk[i].blocks(n)) else {
                own.add(simd, NerfLayer::Trunk(0), outputs, [encoded, Blocks::NONE]);
                return;
            };
            let x = if i == config.skip { [encoded, before] } else { [before, Blocks::NONE] };
            own.add(simd, NerfLayer::Trunk(i), outputs, x);
            let d_before = rows(a, width, n);
            network.trunk[i - 1].apply(simd, [outputs, Blocks::NONE], d_before, panel);
            mask(simd, before, d_before);
            std::mem::swap(a, b);
        }
    }
}

/// Where the layers' own gradients go.
struct Own<'g> {
    network: &'g Network,
    transposed: &'g mut Transposed,
    gradient: &'g mut [f32],
}

impl Own<'_> {
    /// Adds a layer's, from the gradient of its outputs and what it read.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, layer: NerfLayer, outputs: Blocks<'_>, x: [Blocks<'_>; 2]) {
        let place = self.network.offsets.iter().find(|offsets| offsets.layer == layer);
        let Some(Offsets { weight, bias, .. }) = place else { return };
        let n_out = outputs.per_block;
        self.transposed.set(simd, outputs);
        self.transposed.add_biases(simd, &mut self.gradient[*bias..bias + n_out]);
        let mut first = *weight;
        for x in x.into_iter().filter(|x| x.per_block > 0) {
            let end = first + x.per_block * n_out;
            self.transposed.add_weights(simd, x, &mut self.gradient[first..end]);
            first = end;
        }
    }
}

/// How fast a density grows with what it is made of, given the density before its
/// factor.
#[inline(always)]
pub(crate) fn slope(activation: Activation, density: f32) -> f32 {
    match activation {
        Activation::Relu => f32::from(u8::from(density > 0.0)),
        Activation::Softplus => 1.0 - math::exp(-density),
        _ => density,
    }
}

/// The first rows of a buffer: `per_block` of each of `blocks` blocks.
fn rows(buffer: &mut [f32], per_block: usize, blocks: usize) -> &mut [Row] {
    &mut buffer.as_chunks_mut().0[..per_block * blocks]
}

/// Where ReLU gave 0, nothing flows back.
#[inline(always)]
fn mask<S: Simd>(simd: S, outputs: Blocks<'_>, gradient: &mut [Row]) {
    simd.vectorize(
        #[inline(always)]
        || {
            let n = S::f32s::LEN;
            let zero = S::f32s::splat(simd, 0.0);
            let outputs = outputs.rows.as_flattened().chunks_exact(n);
            let gradients = gradient.as_flattened_mut().chunks_exact_mut(n);
            for (output, gradient) in outputs.zip(gradients) {
                let open = S::f32s::from_slice(simd, output).simd_gt(zero);
                open.select(S::f32s::from_slice(simd, gradient), zero).store_slice(gradient);
            }
        },
    );
}
