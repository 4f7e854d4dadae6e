//! A dense layer in memory of its own.

use core::ops::Range;
use std::vec::Vec;

use pocketnerf_core::network::Dense;
use pocketnerf_core::{DType, Error, Layout, TensorView};

/// A dense layer: `[n_in, n_out]`, the outputs' weights of one input side by side.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) n_in: usize,
    pub(super) n_out: usize,
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl Layer {
    /// Of a matrix `[n_in, n_out]`, row after row, and `n_out` biases.
    pub(super) fn new([n_in, n_out]: [usize; 2], weight: Vec<f32>, bias: Vec<f32>) -> Self {
        Self { n_in, n_out, weight, bias }
    }

    /// Of a matrix `[n_out, n_in]`, as torch has it.
    pub(super) fn transposed([n_out, n_in]: [usize; 2], weight: &[f32], bias: Vec<f32>) -> Self {
        let at = |i: usize| weight[i % n_out * n_in + i / n_out];
        Self::new([n_in, n_out], (0..n_in * n_out).map(at).collect(), bias)
    }

    /// The layer of some of its outputs.
    pub(super) fn outputs(&self, range: Range<usize>) -> Self {
        let rows = self.weight.chunks_exact(self.n_out);
        let weight = rows.flat_map(|row| &row[range.clone()]).copied().collect();
        Self::new([self.n_in, range.len()], weight, self.bias[range].to_vec())
    }

    /// The same layer for inputs of which the last `n` come first.
    pub(super) fn last_inputs_first(mut self, n: usize) -> Self {
        self.weight.rotate_right(n * self.n_out);
        self
    }

    /// What a file would hold of it.
    pub(super) fn stored(&self) -> Stored {
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
pub(super) struct Stored {
    shape: [u32; 2],
    weight: Vec<u8>,
    bias: Vec<u8>,
}

impl Stored {
    pub(super) fn view(&self) -> Result<Dense<'_>, Error> {
        let view = |bytes, shape| TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor);
        let weight = view(&self.weight, self.shape)?;
        Ok(Dense { weight, bias: Some(view(&self.bias, [1, self.shape[1]])?) })
    }
}
