//! Dense layers, four columns at a time.

use alloc::vec::Vec;
use core::ops::Range;

use pocketnerf_core::TensorView;
use pocketnerf_core::network::{Dense, Mlp};

/// Numbers that a shader computes with at a time.
pub(crate) const QUAD: usize = 4;

/// A layer in the buffer of weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layer {
    /// Where its matrix begins: one row of four numbers for each input and quad of outputs.
    pub(crate) first: usize,
    /// Where its bias begins, if it has one.
    pub(crate) bias: Option<usize>,
    /// Quads that it reads.
    pub(crate) n_input: usize,
    /// Quads that it writes.
    pub(crate) n_output: usize,
}

/// All layers.
#[derive(Debug, Default)]
pub(super) struct Weights {
    pub(super) rows: Vec<[f32; QUAD]>,
}

/// The first values in their own order, then what fills up the last quad.
pub(super) fn first(n: usize) -> Vec<Option<usize>> {
    padded(0..n)
}

/// Whole quads of values, nothing for what is left of the last one.
#[inline(never)]
pub(super) fn padded(values: Range<usize>) -> Vec<Option<usize>> {
    let n = values.len();
    let value = |i| (i < n).then_some(values.start + i);
    (0..n.next_multiple_of(QUAD)).map(value).collect()
}

impl Weights {
    /// Adds a layer. What the shader has as value i of its input is `inputs[i]` of the
    /// layer's own, or nothing; the same of its outputs.
    #[inline(never)]
    pub(super) fn layer(
        &mut self,
        layer: &Dense<'_>,
        inputs: &[Option<usize>],
        outputs: &[Option<usize>],
    ) -> Layer {
        let (first, n_out) = (self.rows.len(), layer.weight.cols());
        for input in inputs {
            self.row(input.map(|input| (&layer.weight, input * n_out)), outputs);
        }
        let bias = layer.bias.map(|bias| {
            let first = self.rows.len();
            self.row(Some((&bias, 0)), outputs);
            first
        });
        let [n_input, n_output] = [inputs, outputs].map(|values| values.len() / QUAD);
        Layer { first, bias, n_input, n_output }
    }

    /// Adds a number for each output: of a tensor, from a place on, or zeros.
    #[inline(never)]
    fn row(&mut self, from: Option<(&TensorView<'_>, usize)>, outputs: &[Option<usize>]) {
        let value = |output| match (from, output) {
            (Some((tensor, first)), Some(output)) => tensor.get(first + output),
            _ => 0.0,
        };
        for quad in outputs.as_chunks::<QUAD>().0 {
            self.rows.push(quad.map(value));
        }
    }

    /// Adds the layers of a network.
    pub(super) fn network(
        &mut self,
        network: &Mlp<'_>,
        inputs: &[Option<usize>],
        outputs: &[Option<usize>],
    ) -> Vec<Layer> {
        let layers = network.layers();
        let mut inputs = inputs.to_vec();
        let mut packed = Vec::new();
        for (i, layer) in layers.iter().enumerate() {
            let hidden = first(layer.weight.cols());
            let is_last = i + 1 == layers.len();
            packed.push(self.layer(layer, &inputs, if is_last { outputs } else { &hidden }));
            inputs = hidden;
        }
        packed
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{DType, Layout};

    use super::*;

    #[test]
    fn a_layer_by_hand() {
        // Two inputs, three outputs: x0 goes to y by (1, 2, 3), x1 by (4, 5, 6).
        let bytes =
            |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
        let (weight, bias) = (bytes(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), bytes(&[7.0, 8.0, 9.0]));
        let view = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
        let layer = Dense {
            weight: view(&weight, [2, 3]).unwrap(),
            bias: Some(view(&bias, [1, 3]).unwrap()),
        };
        let mut weights = Weights { rows: vec![[0.5; 4]] };
        // The shader has x1 second of the first quad; y1 and y2 first, y0 in a quad of its own.
        let inputs = [Some(0), Some(1), None, None];
        let outputs = [padded(1..3), padded(0..1)].concat();
        let packed = weights.layer(&layer, &inputs, &outputs);
        assert_eq!(packed, Layer { first: 1, bias: Some(9), n_input: 1, n_output: 2 });
        let expected = [
            [2.0, 3.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [5.0, 6.0, 0.0, 0.0],
            [4.0, 0.0, 0.0, 0.0],
        ];
        assert_eq!(weights.rows[1..5], expected);
        assert_eq!(weights.rows[5..9], [[0.0; 4]; 4]);
        assert_eq!(weights.rows[9..], [[8.0, 9.0, 0.0, 0.0], [7.0, 0.0, 0.0, 0.0]]);
    }
}
