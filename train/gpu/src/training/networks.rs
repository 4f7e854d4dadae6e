//! The layers of both networks: which rows their kernels read and write, and their matrices.

use bytemuck::{Pod, Zeroable};
use pocketnerf_core::TensorView;
use pocketnerf_core::network::Mlp;

use crate::shader::{Rows, Together};

/// Rows are written in blocks of so many.
pub(super) const BLOCK: u32 = 16;
/// No bias.
const NONE: u32 = u32::MAX;
/// Rows of a sample's point, before all others.
const POINT: u32 = 3;
/// Bytes that a workgroup shares, on any GPU.
const MEMORY: u32 = 16_384;
/// Parts of the columns whose sums are added up in order, and the sides of their tiles:
/// `dense.wgsl`.
pub(super) const PARTS: u32 = 256;
pub(super) const TILE: u32 = 64;

/// `Shape` in `dense.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Shape {
    n_in: u32,
    pub(super) n_out: u32,
    matrix: u32,
    bias: u32,
    read: u32,
    write: u32,
    mask: u32,
    mode: u32,
}

/// `Product` in `dense.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Product {
    a: u32,
    n_a: u32,
    b: u32,
    n_b: u32,
    weights: u32,
    bias: u32,
    padding: [u32; 2],
}

impl Product {
    /// Tiles of its matrix along both sides.
    pub(super) const fn tiles(&self) -> [u32; 2] {
        [self.n_a.div_ceil(TILE), self.n_b.div_ceil(TILE)]
    }

    /// Values, those of the bias too.
    pub(super) const fn len(&self) -> u32 {
        (self.n_a + 1) * self.n_b
    }
}

/// The kernels of a network.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    pub(super) forward: Vec<Shape>,
    pub(super) backward: Vec<Shape>,
    pub(super) products: Vec<Product>,
}

/// Both networks.
#[derive(Clone, Debug)]
pub(super) struct Networks {
    /// Widths from input to output: of the density network, then of the colour network.
    pub(super) widths: [Vec<u32>; 2],
    pub(super) density: Chain,
    pub(super) color: Chain,
    pub(super) rows: Rows,
    /// Rows of a sample and of a ray.
    pub(super) n_rows: [u32; 2],
    /// Parameters: weights, then the bias of each layer, the density network first.
    pub(super) n_parameters: usize,
    /// Quads of all matrices.
    pub(super) n_quads: usize,
}

/// Rows of the values that are read by layers and of the gradients by them, both from the first
/// input to the output.
#[derive(Debug)]
struct Places {
    values: Vec<u32>,
    gradients: Vec<u32>,
    n_rows: u32,
}

impl Places {
    /// From this row on.
    fn new(widths: &[u32], first: u32) -> Self {
        let mut next = first;
        let mut place = |width: &u32| {
            next += width.next_multiple_of(BLOCK);
            next - width.next_multiple_of(BLOCK)
        };
        let values = widths.iter().map(&mut place).collect();
        let gradients = widths.iter().map(&mut place).collect();
        Self { values, gradients, n_rows: next }
    }
}

impl Networks {
    /// For networks of these widths, from input to output; the colour network's input is
    /// features, then harmonics.
    pub(super) fn new(density: Vec<u32>, color: Vec<u32>, n_features: u32) -> Self {
        let [samples, rays] =
            [Places::new(&density, POINT.next_multiple_of(BLOCK)), Places::new(&color, 0)];
        let last = |places: &[u32]| places.last().copied().unwrap_or(0);
        let mut rows = Rows {
            color_input: [n_features, color[0] - n_features],
            color: [last(&rays.values), last(&rays.gradients), rays.gradients[0]],
            n_encoded: density[0],
            density: [samples.values[0], last(&samples.gradients), samples.gradients[0]],
            together: None,
        };
        let (mut quads, mut parameters) = (0, 0);
        let chains = [(&density, &samples), (&color, &rays)]
            .map(|(widths, places)| chain(widths, places, &mut quads, &mut parameters));
        let [mut density_chain, color_chain] = chains;
        rows.together = together(&density, &density_chain.forward);
        // What it gives is known already.
        density_chain.forward.pop();
        Self {
            density: density_chain,
            color: color_chain,
            rows,
            n_rows: [samples.n_rows, rays.n_rows],
            n_parameters: parameters as usize,
            n_quads: quads as usize,
            widths: [density, color],
        }
    }

    /// Inputs and outputs of all layers, the density network's first.
    pub(super) fn layers(&self) -> impl Iterator<Item = [u32; 2]> {
        let pairs = self.widths.iter().flat_map(|widths| widths.windows(2));
        pairs.map(|pair| [pair[0], pair[1]])
    }

    /// The matrices: forwards of the networks as they are evaluated, backwards of `exact`
    /// parameters.
    pub(super) fn matrices(&self, networks: [&Mlp<'_>; 2], exact: &[f32]) -> Vec<f32> {
        let mut values = Vec::with_capacity(4 * self.n_quads);
        let mut first = 0;
        for (network, widths) in networks.into_iter().zip(&self.widths) {
            for (layer, pair) in network.layers().iter().zip(widths.windows(2)) {
                let [n_in, n_out] = [pair[0] as usize, pair[1] as usize];
                let row = |tensor: &TensorView<'_>, first: usize, values: &mut Vec<f32>| {
                    values.extend((first..first + n_out).map(|i| tensor.get(i)));
                    values.resize(values.len().next_multiple_of(BLOCK as usize), 0.0);
                };
                (0..n_in).for_each(|input| row(&layer.weight, input * n_out, &mut values));
                match &layer.bias {
                    Some(bias) => row(bias, 0, &mut values),
                    None => {
                        values.resize(values.len() + n_out.next_multiple_of(BLOCK as usize), 0.0);
                    }
                }
                let weights = &exact[first..first + n_in * n_out];
                for output in 0..n_out {
                    values.extend((0..n_in).map(|input| weights[input * n_out + output]));
                    values.resize(values.len().next_multiple_of(BLOCK as usize), 0.0);
                }
                first += (n_in + 1) * n_out;
            }
        }
        values
    }
}

/// How the density network is evaluated by workgroups: with one hidden layer that fits into their
/// memory.
fn together(widths: &[u32], layers: &[Shape]) -> Option<Together> {
    let ([n_encoded, n_hidden, n_output], [hidden, given]) = (widths, layers) else { return None };
    let n_given = n_output.div_ceil(4);
    // A column's values, its point, and its step.
    let bytes = 4 * (n_encoded + n_hidden) + 16 * (n_given + 1) + 4;
    let slots = [32, 16].into_iter().find(|slots| slots * bytes + 64 <= MEMORY)?;
    let layer = |shape: &Shape| [shape.matrix, shape.bias, shape.n_out / 4];
    let layers = [hidden, given].map(layer);
    Some(Together { slots, n_hidden: *n_hidden, n_given, layers })
}

/// The kernels of a network; counts its quads and parameters.
fn chain(widths: &[u32], places: &Places, quads: &mut u32, parameters: &mut u32) -> Chain {
    let n_layers = widths.len() - 1;
    let mut chain = Chain::default();
    for (i, pair) in widths.windows(2).enumerate() {
        let [n_in, n_out] = [pair[0], pair[1]];
        let [wide_in, wide_out] = [n_in, n_out].map(|n| n.next_multiple_of(BLOCK));
        let forward = Shape {
            n_in,
            n_out: wide_out,
            matrix: *quads,
            bias: *quads + n_in * wide_out / 4,
            read: places.values[i],
            write: places.values[i + 1],
            mask: 0,
            mode: u32::from(i + 1 < n_layers),
        };
        let backward = Shape {
            n_in: n_out,
            n_out: wide_in,
            matrix: forward.bias + wide_out / 4,
            bias: NONE,
            read: places.gradients[i + 1],
            write: places.gradients[i],
            mask: places.values[i],
            mode: if i > 0 { 2 } else { 0 },
        };
        *quads = backward.matrix + n_out * wide_in / 4;
        chain.products.push(Product {
            a: places.values[i],
            n_a: n_in,
            b: places.gradients[i + 1],
            n_b: n_out,
            weights: *parameters,
            bias: *parameters + n_in * n_out,
            padding: [0; 2],
        });
        *parameters += (n_in + 1) * n_out;
        chain.forward.push(forward);
        chain.backward.insert(0, backward);
    }
    chain
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::network::Dense;
    use pocketnerf_core::{DType, Layout};

    use super::*;

    #[test]
    fn rows_and_matrices_by_hand() {
        // Two encoded values, three hidden ones, density and two features; these and one
        // harmonic become three channels.
        let networks = Networks::new(vec![2, 3, 3], vec![3, 3], 2);
        let Rows { color_input, color, n_encoded, density, together } = networks.rows;
        assert_eq!((color_input, n_encoded), ([2, 1], 2));
        // Behind the first matrix and its bias lies the same matrix for the way back.
        let layers = [[0, 8, 4], [24, 36, 4]];
        assert_eq!(together, Some(Together { slots: 32, n_hidden: 3, n_given: 1, layers }));
        // Blocks of sixteen: points, then values, then gradients.
        assert_eq!(density, [16, 16 + 3 * 16 + 2 * 16, 16 + 3 * 16]);
        assert_eq!((color, networks.n_rows), ([16, 48, 32], [112, 64]));
        assert_eq!((networks.density.forward.len(), networks.density.backward.len()), (1, 2));
        assert_eq!(networks.n_parameters, 9 + 12 + 12);
        let [_, second] = networks.density.products[..] else { panic!() };
        assert_eq!((second.weights, second.bias, second.len()), (9, 18, 12));
        assert_eq!(second.tiles(), [1, 1]);
        assert_eq!(Product { n_a: 64, n_b: 65, ..second }.tiles(), [1, 2]);
        let bytes =
            |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
        let tensor = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
        let numbers: Vec<f32> = (0..33u8).map(f32::from).collect();
        let all = bytes(&numbers);
        let layer = |first: usize, n_in: usize| {
            let (weight, bias) = all[4 * first..].split_at(12 * n_in);
            let weight = tensor(weight, [n_in as u32, 3]).unwrap();
            Dense { weight, bias: Some(tensor(&bias[..12], [1, 3]).unwrap()) }
        };
        let density = Mlp::new(&[layer(0, 2), layer(9, 3)]).unwrap();
        let color = Mlp::new(&[layer(21, 3)]).unwrap();
        let exact: Vec<f32> = numbers.iter().map(|v| v + 100.0).collect();
        let values = networks.matrices([&density, &color], &exact);
        assert_eq!(values.len(), 4 * networks.n_quads);
        let Shape { matrix, bias, .. } = networks.density.forward[0];
        let at = |quad: u32| &values[4 * quad as usize..];
        assert_eq!(at(matrix)[..4], [0.0, 1.0, 2.0, 0.0]);
        assert_eq!(at(matrix)[16], 3.0);
        assert_eq!(at(bias)[..4], [6.0, 7.0, 8.0, 0.0]);
        // Backwards: a row an output, of what is exact.
        let back = networks.density.backward[1];
        assert_eq!((back.n_in, back.n_out, back.mode), (3, 16, 0));
        assert_eq!(at(back.matrix)[..3], [100.0, 103.0, 0.0]);
        assert_eq!(at(back.matrix)[16..18], [101.0, 104.0]);
        let hidden = networks.density.backward[0];
        assert_eq!((hidden.mode, hidden.mask), (2, 32));
        assert_eq!(at(networks.color.forward[0].matrix)[..3], [21.0, 22.0, 23.0]);
    }
}
