//! Where the parameters of a network lie in one vector, and how they begin.

use std::ops::Range;

use pocketnerf_train::random::{Random, normal};

use super::Real;

/// A network's parameters, one tensor after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    tensors: Vec<Tensor>,
    len: usize,
}

/// One tensor.
#[derive(Clone, Debug)]
struct Tensor {
    range: Range<usize>,
    mean: f64,
    /// Standard deviation of its initial values.
    deviation: f64,
}

impl Layout {
    /// Adds a tensor of `n` values, normally distributed at first.
    pub(crate) fn add(&mut self, n: usize, mean: f64, deviation: f64) -> Range<usize> {
        let range = self.len..self.len + n;
        self.len += n;
        self.tensors.push(Tensor { range: range.clone(), mean, deviation });
        range
    }

    /// Number of parameters.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The tensors, in order.
    #[cfg(test)]
    pub(crate) fn tensors(&self) -> impl Iterator<Item = Range<usize>> {
        self.tensors.iter().map(|tensor| tensor.range.clone())
    }

    /// Initial values.
    pub(crate) fn init<T: Real>(&self, seed: u64) -> Vec<T> {
        let tensors = self.tensors.iter().zip(0..);
        let values = tensors.flat_map(|(tensor, i)| {
            let mut random = Random::new(seed, [INIT, i, 0]);
            let draw =
                move |_| T::of(tensor.mean + tensor.deviation * f64::from(normal(&mut random)));
            tensor.range.clone().map(draw)
        });
        values.collect()
    }
}

/// The purpose of these random numbers.
const INIT: u64 = 11;
