//! A dense layer of a checkpoint, in memory of its own.

use core::ops::Range;
use std::vec::Vec;

use pocketnerf_core::network::Dense;
use pocketnerf_core::{DType, Error, Layout, TensorView};

/// A dense layer: `[n_in, n_out]`, the outputs' weights of one input side by side.
#[derive(Clone, Debug)]
pub(in crate::import) struct Layer {
    pub(in crate::import) n_in: usize,
    pub(in crate::import) n_out: usize,
    weight: Vec<f32>,
    /// Empty for none.
    bias: Vec<f32>,
}

impl Layer {
    /// Of a matrix `[n_in, n_out]`, row after row, and `n_out` biases or none.
    pub(in crate::import) fn new(
        [n_in, n_out]: [usize; 2],
        weight: Vec<f32>,
        bias: Vec<f32>,
    ) -> Self {
        Self { n_in, n_out, weight, bias }
    }

    /// Of a matrix `[n_out, n_in]`, as torch has it.
    pub(in crate::import) fn transposed(
        [n_out, n_in]: [usize; 2],
        weight: &[f32],
        bias: Vec<f32>,
    ) -> Self {
        let at = |i: usize| weight[i % n_out * n_in + i / n_out];
        Self::new([n_in, n_out], (0..n_in * n_out).map(at).collect(), bias)
    }

    /// The layer of some of its outputs.
    pub(in crate::import) fn outputs(&self, range: Range<usize>) -> Self {
        let rows = self.weight.chunks_exact(self.n_out);
        let weight = rows.flat_map(|row| &row[range.clone()]).copied().collect();
        Self::new(
            [self.n_in, range.len()],
            weight,
            self.bias.get(range).unwrap_or_default().to_vec(),
        )
    }

    /// The layer whose first output is there once more, before the others.
    pub(in crate::import) fn first_output_twice(&self) -> Self {
        let outputs = [0].into_iter().chain(0..self.n_out);
        let rows = self.weight.chunks_exact(self.n_out);
        let weight = rows.flat_map(|row| outputs.clone().map(|o| row[o])).collect();
        let n_out = outputs.clone().count();
        let bias =
            if self.bias.is_empty() { Vec::new() } else { outputs.map(|o| self.bias[o]).collect() };
        Self::new([self.n_in, n_out], weight, bias)
    }

    /// The layer whose first inputs are given as sums of others, as many: input i was the
    /// sum of those with the factors of row i.
    pub(in crate::import) fn with_first_inputs<const N: usize>(
        &self,
        rows: &[[f64; N]; N],
    ) -> Self {
        let mut layer = self.clone();
        for (j, to) in layer.weight.chunks_exact_mut(self.n_out).take(N).enumerate() {
            for (o, weight) in to.iter_mut().enumerate() {
                let part = |i: usize| rows[i][j] * f64::from(self.weight[i * self.n_out + o]);
                *weight = (0..N).map(part).sum::<f64>() as f32;
            }
        }
        layer
    }

    /// The layer of its first `n_in` inputs; the others hold `padding`, which becomes a
    /// bias.
    pub(in crate::import) fn without_padding(mut self, n_in: usize, padding: f32) -> Self {
        let rest = self.weight.split_off(n_in * self.n_out);
        if padding != 0.0 && !rest.is_empty() {
            let mut bias: Vec<f64> = (0..self.n_out)
                .map(|o| self.bias.get(o).map_or(0.0, |bias| f64::from(*bias)))
                .collect();
            for row in rest.chunks_exact(self.n_out) {
                let padding = f64::from(padding);
                bias.iter_mut().zip(row).for_each(|(b, w)| *b += padding * f64::from(*w));
            }
            self.bias = bias.into_iter().map(|bias| bias as f32).collect();
        }
        self.n_in = n_in;
        self
    }

    /// The same layer for inputs of which the last `n` come first.
    pub(in crate::import) fn last_inputs_first(mut self, n: usize) -> Self {
        self.weight.rotate_right(n * self.n_out);
        self
    }

    /// What a file would hold of it.
    pub(in crate::import) fn stored(&self) -> Stored {
        let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
        Stored {
            shape: [self.n_in, self.n_out].map(|n| n as u32),
            weight: bytes(&self.weight),
            bias: bytes(&self.bias),
        }
    }
}

/// A layer's bytes, f32.
#[derive(Clone, Debug)]
pub(in crate::import) struct Stored {
    shape: [u32; 2],
    weight: Vec<u8>,
    bias: Vec<u8>,
}

impl Stored {
    pub(in crate::import) fn view(&self) -> Result<Dense<'_>, Error> {
        let view = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
        let weight = view(&self.weight, self.shape)?;
        let bias = (!self.bias.is_empty()).then(|| view(&self.bias, [1, self.shape[1]]));
        Ok(Dense { weight, bias: bias.transpose()? })
    }
}
