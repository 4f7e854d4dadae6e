//! The paper's field (Mildenhall et al. 2020, section 5 and figure 7): Fourier
//! features, a deep network, density from its last layer, colour from that layer's
//! features and the direction.

use fearless_simd::{Simd, SimdBase};

use crate::encoding::{Affine, Fourier};
use crate::field::{Field, Samples};
use crate::network::blocks::{BLOCK, Blocks, Row, dense_blocks};
use crate::network::{Dense, MAX_LAYERS, Mlp};
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;
use crate::{Error, lanes};

/// How the network's output becomes a density.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// `max(x, 0)`: the paper's.
    Relu,
    /// `ln(1 + e^x)`.
    Softplus,
    /// `e^x`, cut off at e^15.
    Exp,
}

/// The networks of one field: `trunk` reads the encoded point; `density` and
/// `feature` read what the trunk gives; `color` reads the feature, then the encoded
/// direction.
#[derive(Clone, Copy, Debug)]
pub struct NerfNetwork<'a> {
    trunk: [Dense<'a>; MAX_LAYERS],
    depth: usize,
    /// Bit i: layer i of the trunk reads the encoded point once more, before what the
    /// layer before gives (a skip connection).
    pub skips: u16,
    /// Bit i: no ReLU after layer i of the trunk.
    pub linear: u16,
    /// `[width, 1]`: the density before its activation.
    pub density: Dense<'a>,
    /// `[width, n]`; `None`: the colour network reads the trunk.
    pub feature: Option<Dense<'a>>,
    /// Whether ReLU follows the feature. Not in the paper.
    pub feature_bends: bool,
    /// Feature and encoded direction to colour before the logistic. ReLU between layers.
    pub color: Mlp<'a>,
}

/// The paper's field.
#[derive(Clone, Copy, Debug)]
pub struct NerfField<'a> {
    /// Encoding of positions.
    pub positions: Fourier<'a>,
    /// Encoding of directions; `None`: colours do not depend on them.
    pub directions: Option<Fourier<'a>>,
    /// From unit coordinates to those that are encoded.
    pub map: Affine,
    /// From the network's output to a density.
    pub activation: Activation,
    /// Factor on densities: carries the unit of length.
    pub density_scale: f32,
    /// The networks that pictures are made with.
    pub fine: NerfNetwork<'a>,
    /// Those that say where samples are worth while in the paper's sampling; `None`:
    /// the same.
    pub coarse: Option<NerfNetwork<'a>>,
}

/// e^15: densities are cut off here, before the factor.
const MAX_SIGMA: f32 = 3_269_017.4;

/// Blocks that go through all layers together: what a layer of 256 reads and writes, half
/// a megabyte each, about fits a core's second-level cache, and decoding weights is 2 %
/// of the work. Measured against 4, 8 and 12.
const BLOCKS: usize = 16;

impl<'a> NerfNetwork<'a> {
    /// A network of these layers; [`NerfField::validate`] checks that they fit together.
    /// `skips` and `linear` come together.
    ///
    /// # Errors
    /// [`Error::Range`] for too many layers in the trunk, or none.
    pub fn new(
        trunk: &[Dense<'a>],
        [skips, linear]: [u16; 2],
        density: Dense<'a>,
        feature: Option<Dense<'a>>,
        color: Mlp<'a>,
    ) -> Result<Self, Error> {
        if trunk.is_empty() || trunk.len() > MAX_LAYERS {
            return Err(Error::Range("network: number of layers"));
        }
        let mut all = [Dense::EMPTY; MAX_LAYERS];
        all[..trunk.len()].copy_from_slice(trunk);
        let depth = trunk.len();
        let feature_bends = false;
        Ok(Self { trunk: all, depth, skips, linear, density, feature, feature_bends, color })
    }

    /// The trunk, first layer to last.
    #[must_use]
    pub fn trunk(&self) -> &[Dense<'a>] {
        &self.trunk[..self.depth]
    }

    /// Whether layer `i` of the trunk reads the encoded point once more.
    #[must_use]
    pub const fn skips(&self, i: usize) -> bool {
        self.skips >> i & 1 == 1
    }

    /// Whether ReLU follows layer `i` of the trunk.
    #[must_use]
    pub const fn bends(&self, i: usize) -> bool {
        self.linear >> i & 1 == 0
    }

    /// All layers: the trunk's, the density's, the feature's, the colour network's.
    pub fn layers(&self) -> impl Iterator<Item = &Dense<'a>> {
        let heads = core::iter::once(&self.density).chain(&self.feature);
        self.trunk().iter().chain(heads).chain(self.color.layers())
    }

    /// Checks the layers; so many values encode a position and a direction.
    fn validate(&self, n_position: usize, n_direction: usize) -> Result<(), Error> {
        for layer in self.layers() {
            layer.validate(self.trunk[0].weight.dtype())?;
        }
        if self.skips & 1 != 0
            || (u32::from(self.skips) | u32::from(self.linear)) >> self.depth != 0
        {
            return Err(Error::Range("network: a skip connection or a layer without ReLU"));
        }
        let mut width = 0;
        for (i, layer) in self.trunk().iter().enumerate() {
            let again = if i == 0 || self.skips(i) { n_position } else { 0 };
            if layer.weight.rows() != again + width {
                return Err(Error::Shape("network: a layer of the trunk and what it reads"));
            }
            width = layer.weight.cols();
        }
        if [self.density.weight.rows(), self.density.weight.cols()] != [width, 1] {
            return Err(Error::Shape("network: the density's layer"));
        }
        if let Some(feature) = &self.feature {
            if feature.weight.rows() != width {
                return Err(Error::Shape("network: the feature's layer"));
            }
            width = feature.weight.cols();
        }
        if self.color.n_input() != width + n_direction || self.color.n_output() != 3 {
            return Err(Error::Shape("network: the colour network"));
        }
        Ok(())
    }

    /// The widest of what goes from one layer to the next.
    fn widest(&self) -> usize {
        let outputs = self.layers().map(|layer| layer.weight.cols());
        outputs.max().unwrap_or(0)
    }

    /// The most values that a layer reads.
    fn most_inputs(&self) -> usize {
        self.layers().map(|layer| layer.weight.rows()).max().unwrap_or(0)
    }
}

impl NerfField<'_> {
    /// Checks that encodings and networks fit together.
    ///
    /// # Errors
    /// [`Error::Shape`] or [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        self.positions.validate()?;
        let mut n_direction = 0;
        if let Some(directions) = &self.directions {
            directions.validate()?;
            n_direction = directions.n_output();
        }
        let Affine { scale, offset } = self.map;
        if !scale.iter().chain(&offset).all(|v| v.is_finite() && v.abs() <= 1e6) {
            return Err(Error::Range("the map of positions"));
        }
        if !(self.density_scale > 0.0 && self.density_scale < 1e9) {
            return Err(Error::Range("the factor on densities"));
        }
        for network in core::iter::once(&self.fine).chain(&self.coarse) {
            network.validate(self.positions.n_output(), n_direction)?;
            if network.trunk[0].weight.dtype() != self.dtype() {
                return Err(Error::Shape("networks of different types"));
            }
        }
        Ok(())
    }

    /// The field of the coarse network, or the same field.
    #[must_use]
    pub fn coarse_field(&self) -> Self {
        Self { fine: self.coarse.unwrap_or(self.fine), coarse: None, ..*self }
    }

    /// Values that encode a direction.
    #[must_use]
    pub fn n_direction(&self) -> usize {
        self.directions.as_ref().map_or(0, Fourier::n_output)
    }

    /// The largest of a number over both networks.
    fn most(&self, of: impl Fn(&NerfNetwork<'_>) -> usize) -> usize {
        of(&self.fine).max(self.coarse.as_ref().map_or(0, of))
    }
}

impl Field for NerfField<'_> {
    fn deferred(&self) -> Option<&crate::field::Decoder<'_>> {
        None
    }

    fn channels(&self) -> usize {
        3
    }

    fn dtype(&self) -> DType {
        self.fine.trunk[0].weight.dtype()
    }

    /// Encoded points and one layer in the first buffer; the layer after it and
    /// encoded directions in the other.
    fn limits(&self) -> Limits {
        let n_position = self.positions.n_output();
        let widest = self.most(|n| n.widest());
        Limits {
            width: self.most(|n| n.most_inputs()).max(widest),
            rows: [n_position + widest, self.n_direction() + widest],
            channels: 3,
            ray_samples: 0,
        }
    }

    #[inline(always)]
    fn encode<S: Simd>(&self, simd: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        simd.vectorize(
            #[inline(always)]
            || {
                let n = self.positions.n_output() * points[0].len().div_ceil(BLOCK);
                let out = &mut work.a.as_chunks_mut().0[..n];
                self.positions.encode(simd, points, self.map, out);
            },
        );
    }

    #[inline(always)]
    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.ask(simd, samples, work, true);
    }

    /// Without the feature and the colour network.
    #[inline(always)]
    fn densities<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.encode(simd, samples.points, work);
        self.ask(simd, samples, work, false);
    }
}

impl NerfField<'_> {
    /// The networks over encoded points; without colours where they are not `wanted`.
    #[inline(always)]
    fn ask<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>, wanted: bool) {
        let Workspace { a, b, output, panel, stride } = work;
        let [n_position, n_direction] = [self.positions.n_output(), self.n_direction()];
        let n_blocks = samples.len().div_ceil(BLOCK);
        let (encoded, a) = a.as_chunks_mut::<BLOCK>().0.split_at_mut(n_position * n_blocks);
        let room = *stride / BLOCK * n_direction;
        let (directions, b) = b.as_chunks_mut::<BLOCK>().0.split_at_mut(room);
        let most = BLOCKS.min(a.len().min(b.len()) / self.fine.widest());
        let (mut first, len) = (0, samples.len());
        while first * BLOCK < len {
            let blocks = most.min(n_blocks - first);
            let (begin, end) = (first * BLOCK, len.min((first + blocks) * BLOCK));
            if let (Some(encoding), true) = (&self.directions, wanted) {
                let d = [0, 1, 2].map(|axis| &samples.directions[axis][begin..end]);
                let out = &mut directions[..n_direction * blocks];
                simd.vectorize(
                    #[inline(always)]
                    || encoding.encode(simd, d, Affine::IDENTITY, out),
                );
            }
            let x = &encoded[n_position * first..n_position * (first + blocks)];
            let x = Blocks { rows: x, per_block: n_position };
            let d = &directions[..n_direction * blocks];
            let d = Blocks { rows: d, per_block: n_direction };
            let (density, rows) = output.split_at_mut(*stride);
            let density = &mut density[begin..];
            let density = &mut density.as_chunks_mut().0[..blocks];
            let d = wanted.then_some(d);
            let rgb = self.fine.forward(simd, (x, d), [a, b], density, panel);
            for (block, rgb) in rgb.chunks_exact(3).enumerate() {
                let at = begin + block * BLOCK;
                let n = BLOCK.min(end - at);
                for (row, rgb) in rows.chunks_mut(*stride).zip(rgb) {
                    row[at..at + n].copy_from_slice(&rgb[..n]);
                }
            }
            first += blocks;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                for values in output[..len].chunks_exact_mut(S::f32s::LEN) {
                    let raw = S::f32s::from_slice(simd, values);
                    self.sigma(simd, raw).store_slice(values);
                }
                let colors = if wanted { 3 } else { 0 };
                for row in output[*stride..].chunks_mut(*stride).take(colors) {
                    for values in row[..len].chunks_exact_mut(S::f32s::LEN) {
                        let raw = S::f32s::from_slice(simd, values);
                        lanes::logistic(simd, raw).store_slice(values);
                    }
                }
            },
        );
    }
}

impl NerfField<'_> {
    /// Densities, 1 / scene unit, of what the network gives. NaN is empty.
    #[inline(always)]
    pub fn sigma<S: Simd>(&self, simd: S, raw: S::f32s) -> S::f32s {
        let [zero, most] = [0.0, MAX_SIGMA].map(|v| S::f32s::splat(simd, v));
        let density = match self.activation {
            // In this order, NaN becomes 0.
            Activation::Relu => raw.max_precise(zero).min_precise(most),
            Activation::Softplus => lanes::softplus(simd, raw).min_precise(most),
            Activation::Exp => lanes::exp(simd, raw).min(most),
        };
        density * self.density_scale
    }
}

impl NerfNetwork<'_> {
    /// From encoded points and directions to densities before their activation, a row a
    /// block, and colours before theirs, `[block][3]`, which end in one of the two
    /// buffers: each has room for the widest layer. Without directions there are no
    /// colours.
    fn forward<'b, S: Simd>(
        &self,
        simd: S,
        (x, directions): (Blocks<'_>, Option<Blocks<'_>>),
        [a, b]: [&'b mut [Row]; 2],
        density: &mut [Row],
        panel: &mut [f32],
    ) -> &'b [Row] {
        let blocks = density.len();
        let rows = |n: usize| n * blocks;
        let (mut from, mut to) = (a, b);
        let mut width = 0;
        for (i, layer) in self.trunk().iter().enumerate() {
            let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
            let sources = match (i, self.skips(i)) {
                (0, _) => [x, Blocks::NONE],
                (_, true) => [x, hidden],
                (_, false) => [hidden, Blocks::NONE],
            };
            width = layer.weight.cols();
            let y = &mut to[..rows(width)];
            dense_blocks(simd, layer, sources, y, self.bends(i), panel);
            core::mem::swap(&mut from, &mut to);
        }
        let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
        dense_blocks(simd, &self.density, [hidden, Blocks::NONE], density, false, panel);
        let Some(directions) = directions else { return &[] };
        if let Some(feature) = &self.feature {
            width = feature.weight.cols();
            let y = &mut to[..rows(width)];
            let bends = self.feature_bends;
            dense_blocks(simd, feature, [hidden, Blocks::NONE], y, bends, panel);
            core::mem::swap(&mut from, &mut to);
        }
        let last = self.color.layers().len() - 1;
        for (i, layer) in self.color.layers().iter().enumerate() {
            let hidden = Blocks { rows: &from[..rows(width)], per_block: width };
            let second = if i == 0 { directions } else { Blocks::NONE };
            width = layer.weight.cols();
            let y = &mut to[..rows(width)];
            dense_blocks(simd, layer, [hidden, second], y, i != last, panel);
            core::mem::swap(&mut from, &mut to);
        }
        &from[..rows(width)]
    }
}
