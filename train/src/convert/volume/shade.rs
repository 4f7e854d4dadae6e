//! Colours of TensoRF's features: a network of them and of directions, or what is plainer.

use fearless_simd::{Level, Simd, dispatch};
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::network::blocks::{BLOCK, Blocks, Row, dense_blocks};
use pocketnerf_core::network::{Dense, panel_len};
use pocketnerf_core::{Error, math};
use pocketnerf_formats::import::volume::{Shading, TensoRf};

use super::factors::{Place, products};

/// Blocks of samples that a layer takes at a time.
const BLOCKS: usize = 8;
/// Harmonics of a colour.
const HARMONICS: usize = 9;

/// A sample that has a colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Which pixel it adds to.
    pub(super) pixel: usize,
    /// How much of its colour is seen.
    pub(super) weight: f32,
    pub(super) point: [f32; 3],
    /// Of unit length.
    pub(super) direction: [f32; 3],
}

/// Gathers samples, and adds their colours to pixels.
pub(super) struct Shader<'f> {
    field: &'f TensoRf,
    basis: Dense<'f>,
    network: Vec<Dense<'f>>,
    samples: Vec<Sample>,
    products: Vec<f32>,
    /// What a layer reads, and what it gives.
    rows: [Vec<Row>; 2],
    panel: Vec<f32>,
}

impl<'f> Shader<'f> {
    pub(super) fn new(field: &'f TensoRf) -> Result<Self, Error> {
        let (basis, network) = (field.basis()?, field.network()?);
        let widths = network.iter().chain([&basis]).flat_map(|layer| layer.weight.shape());
        let widest = widths.max().unwrap_or(0) as usize;
        Ok(Self {
            field,
            basis,
            network,
            samples: Vec::with_capacity(BLOCKS * BLOCK),
            products: vec![0.0; field.appearance.n_products()],
            rows: [const { Vec::new() }; 2].map(|_: Vec<Row>| vec![[0.0; BLOCK]; BLOCKS * widest]),
            panel: vec![0.0; panel_len(widest)],
        })
    }

    /// Takes a sample; where there is no room for another one, all get their colours.
    pub(super) fn push(&mut self, level: Level, sample: Sample, pixels: &mut [[f32; 4]]) {
        self.samples.push(sample);
        if self.samples.len() == BLOCKS * BLOCK {
            self.flush(level, pixels);
        }
    }

    /// Adds the colours of all samples, in their order.
    pub(super) fn flush(&mut self, level: Level, pixels: &mut [[f32; 4]]) {
        if !self.samples.is_empty() {
            dispatch!(level, simd => self.shade(simd));
            for (i, sample) in self.samples.iter().enumerate() {
                let block = &self.rows[0][i / BLOCK * 3..][..3];
                for (pixel, row) in pixels[sample.pixel].iter_mut().zip(block) {
                    *pixel += sample.weight * row[i % BLOCK];
                }
            }
            self.samples.clear();
        }
    }

    /// The colours of all samples, three rows a block of `rows[0]`.
    fn shade<S: Simd>(&mut self, simd: S) {
        let TensoRf { bounds, sizes, appearance, shading, .. } = self.field;
        let blocks = self.samples.len().div_ceil(BLOCK);
        let [x, y] = &mut self.rows;
        let n_products = self.products.len();
        for (i, sample) in self.samples.iter().enumerate() {
            let place = Place::of(sample.point, *bounds, *sizes);
            products(appearance, place, *sizes, &mut self.products);
            for (row, product) in x[i / BLOCK * n_products..].iter_mut().zip(&self.products) {
                row[i % BLOCK] = *product;
            }
        }
        let mut layer = |x: &[Row], y: &mut [Row], layer: &Dense<'_>, relu: bool| {
            let [n_in, n_out] = layer.weight.shape().map(|n| n as usize);
            let rows = Blocks { rows: &x[..blocks * n_in], per_block: n_in };
            let y = &mut y[..blocks * n_out];
            dense_blocks(simd, layer, [rows, Blocks::NONE], y, relu, &mut self.panel);
        };
        layer(x, y, &self.basis, false);
        let n_features = self.basis.weight.cols();
        let features = y.chunks_exact(n_features).zip(self.samples.chunks(BLOCK)).enumerate();
        match *shading {
            Shading::Network { features: octaves, directions } => {
                let n_in = self.network[0].weight.rows();
                for (b, (features, samples)) in features {
                    let to = &mut x[b * n_in..][..n_in];
                    encode(features, samples, [octaves, directions], to);
                }
                let last = self.network.len() - 1;
                for (i, dense) in self.network.iter().enumerate() {
                    layer(x, y, dense, i < last);
                    core::mem::swap(x, y);
                }
                for value in x[..3 * blocks].as_flattened_mut() {
                    *value = 1.0 / (1.0 + (-*value).exp());
                }
            }
            Shading::Harmonics => {
                for (b, (features, samples)) in features {
                    for (s, sample) in samples.iter().enumerate() {
                        let mut harmonics = [0.0; HARMONICS];
                        spherical_harmonics::evaluate(3, sample.direction, &mut harmonics);
                        for color in 0..3 {
                            let of = &features[color * HARMONICS..];
                            let terms = harmonics.iter().zip(of).map(|(h, row)| h * row[s]);
                            x[3 * b + color][s] = (0.5 + terms.sum::<f32>()).max(0.0);
                        }
                    }
                }
            }
            Shading::Colors => core::mem::swap(x, y),
        }
    }
}

/// What the network reads: features, direction, and both encoded.
fn encode(features: &[Row], samples: &[Sample], octaves: [u32; 2], to: &mut [Row]) {
    let n = features.len();
    to[..n].copy_from_slice(features);
    let (direction, encoded) = to[n..].split_at_mut(3);
    for (s, sample) in samples.iter().enumerate() {
        (0..3).for_each(|a| direction[a][s] = sample.direction[a]);
    }
    let (of_features, of_directions) = encoded.split_at_mut(2 * n * octaves[0] as usize);
    waves(features, octaves[0], of_features);
    waves(direction, octaves[1], of_directions);
}

/// Sines of all octaves of the first row, of the second and so on, then cosines.
fn waves(of: &[Row], octaves: u32, to: &mut [Row]) {
    let (sines, cosines) = to.split_at_mut(of.len() * octaves as usize);
    let places = sines.iter_mut().zip(cosines).enumerate();
    for (i, (sines, cosines)) in places {
        let (row, octave) = (i / octaves as usize, i % octaves as usize);
        let factor = (1u32 << octave) as f32;
        for ((sine, cosine), value) in sines.iter_mut().zip(cosines).zip(&of[row]) {
            (*sine, *cosine) = math::sin_cos(factor * value);
        }
    }
}
