//! Vanilla NeRF (Mildenhall et al. 2020, section 5 and figure 7): Fourier features, a deep
//! network, density from its last layer, colour from that layer's features and the
//! direction.

mod network;
mod reference;

pub use network::NerfNetwork;

use fearless_simd::{Simd, SimdBase};

use crate::encoding::{Affine, Fourier, Waves};
use crate::field::{AnyField, Field, FieldKernels, MAX_SIGMA, Samples};
use crate::network::blocks::{BLOCK, Blocks};
use crate::scratch::{Limits, Workspace};
use crate::tensor::DType;
use crate::{Error, lanes};

/// How the network's output becomes a density.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// `max(x, 0)`, as in the paper.
    Relu,
    /// `ln(1 + e^x)`.
    Softplus,
    /// `e^x`, cut off at e^15.
    Exp,
}

/// A vanilla NeRF.
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
    /// Those that place the samples of hierarchical sampling; `None`: the same.
    pub coarse: Option<NerfNetwork<'a>>,
}

/// Blocks that go through all layers together: what a layer of 256 reads and writes, half
/// a megabyte each, about fits a core's second-level cache, and decoding weights is 2 %
/// of the work. Measured against 4, 8 and 12.
const BLOCKS: usize = 16;

impl NerfField<'_> {
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
    fn kind(&self) -> &'static str {
        "nerf"
    }

    fn channels(&self) -> usize {
        3
    }

    fn dtype(&self) -> DType {
        self.fine.trunk()[0].weight.dtype()
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

    /// A quarter of the shortest wave.
    fn finest_detail(&self) -> f32 {
        let map = self.map.scale.iter().fold(0.0, |most: f32, s| most.max(s.abs()));
        0.25 / (highest_frequency(&self.positions) * map).max(1e-3)
    }

    fn validate(&self) -> Result<(), Error> {
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
            if network.trunk()[0].weight.dtype() != self.dtype() {
                return Err(Error::Shape("networks of different types"));
            }
        }
        Ok(())
    }

    fn coarse(&self) -> Option<AnyField<'_>> {
        self.coarse.map(|_| AnyField::Nerf(self.coarse_field()))
    }
}

impl FieldKernels for NerfField<'_> {
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

    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.networks(simd, samples.len(), Some(samples.directions), work);
    }

    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        self.networks(simd, n, None, work);
    }
}

impl NerfField<'_> {
    /// The networks over `len` encoded points; without the feature and the colour network
    /// where there are no directions.
    fn networks<S: Simd>(
        &self,
        simd: S,
        len: usize,
        directions: Option<[&[f32]; 3]>,
        work: &mut Workspace<'_>,
    ) {
        let Workspace { a, b, output, panel, stride, .. } = work;
        let [n_position, n_direction] = [self.positions.n_output(), self.n_direction()];
        let n_blocks = len.div_ceil(BLOCK);
        let (encoded, a) = a.as_chunks_mut::<BLOCK>().0.split_at_mut(n_position * n_blocks);
        let room = *stride / BLOCK * n_direction;
        let (encoded_directions, b) = b.as_chunks_mut::<BLOCK>().0.split_at_mut(room);
        let most = BLOCKS.min(a.len().min(b.len()) / self.fine.widest());
        let mut first = 0;
        while first * BLOCK < len {
            let blocks = most.min(n_blocks - first);
            let (begin, end) = (first * BLOCK, len.min((first + blocks) * BLOCK));
            if let (Some(encoding), Some(directions)) = (&self.directions, directions) {
                let d = [0, 1, 2].map(|axis| &directions[axis][begin..end]);
                let out = &mut encoded_directions[..n_direction * blocks];
                simd.vectorize(
                    #[inline(always)]
                    || encoding.encode(simd, d, Affine::IDENTITY, out),
                );
            }
            let x = &encoded[n_position * first..n_position * (first + blocks)];
            let x = Blocks { rows: x, per_block: n_position };
            let d = &encoded_directions[..n_direction * blocks];
            let d = Blocks { rows: d, per_block: n_direction };
            let (density, rows) = output.split_at_mut(*stride);
            let density = &mut density[begin..];
            let density = &mut density.as_chunks_mut().0[..blocks];
            let d = directions.is_some().then_some(d);
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
                let colors = if directions.is_some() { 3 } else { 0 };
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
    /// Densities, 1 / scene unit, of the network's output. NaN is empty.
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

/// Of the waves in what is encoded, the most that go into a length of 1.
fn highest_frequency(positions: &Fourier<'_>) -> f32 {
    match &positions.waves {
        Waves::Octaves { n: 0, .. } => 1.0,
        Waves::Octaves { n, pi } => {
            let half_turns = (1u32 << (n - 1)) as f32;
            half_turns * if *pi { 0.5 } else { core::f32::consts::FRAC_1_PI / 2.0 }
        }
        Waves::Gaussian(matrix) => {
            let n = matrix.cols();
            let square = |at: usize| matrix.get(at) * matrix.get(at);
            let squares = |i: usize| square(i) + square(n + i) + square(2 * n + i);
            crate::math::sqrt((0..n).map(squares).fold(0.0, f32::max))
        }
    }
}
