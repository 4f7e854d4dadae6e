//! A layer that multiplies by a matrix and adds a bias.

use std::ops::Range;

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};

use super::{Layout, Real};

/// y = x W + b, for a batch: x has a row a sample.
#[derive(Clone, Debug)]
pub(crate) struct Dense {
    inputs: usize,
    outputs: usize,
    weights: Range<usize>,
    biases: Range<usize>,
}

impl Dense {
    /// With weights that keep the variance of what a ReLU lets through (He et al. 2015), times
    /// `gain`, and biases that vary as those of PyTorch.
    pub(crate) fn new(layout: &mut Layout, inputs: usize, outputs: usize, gain: f64) -> Self {
        let deviation = gain * (2.0 / inputs as f64).sqrt();
        let weights = layout.add(inputs * outputs, 0.0, deviation);
        let biases = layout.add(outputs, 0.0, gain / (3.0 * inputs as f64).sqrt());
        Self { inputs, outputs, weights, biases }
    }

    pub(crate) fn forward<T: Real>(&self, parameters: &[T], x: &ArrayView2<'_, T>) -> Array2<T> {
        let bias = &parameters[self.biases.clone()];
        let mut y = Array2::from_shape_fn((x.nrows(), self.outputs), |(_, j)| bias[j]);
        general_mat_mul(T::one(), x, &self.matrix(parameters), T::one(), &mut y);
        y
    }

    /// Adds to the parameters' gradient, and gives that of `x`.
    pub(crate) fn backward<T: Real>(
        &self,
        parameters: &[T],
        x: &ArrayView2<'_, T>,
        dy: &ArrayView2<'_, T>,
        gradient: &mut [T],
    ) -> Array2<T> {
        self.backward_parameters(x, dy, gradient);
        let mut dx = Array2::zeros((x.nrows(), self.inputs));
        general_mat_mul(T::one(), dy, &self.matrix(parameters).t(), T::zero(), &mut dx);
        dx
    }

    /// Adds to the parameters' gradient alone.
    pub(crate) fn backward_parameters<T: Real>(
        &self,
        x: &ArrayView2<'_, T>,
        dy: &ArrayView2<'_, T>,
        gradient: &mut [T],
    ) {
        let weights = &mut gradient[self.weights.clone()];
        let mut weights =
            ArrayViewMut2::from_shape((self.inputs, self.outputs), weights).expect("its own shape");
        general_mat_mul(T::one(), &x.t(), dy, T::one(), &mut weights);
        let sums = dy.sum_axis(Axis(0));
        gradient[self.biases.clone()].iter_mut().zip(&sums).for_each(|(g, sum)| *g += *sum);
    }

    /// Where its biases are.
    pub(crate) fn biases(&self) -> Range<usize> {
        self.biases.clone()
    }

    fn matrix<'p, T>(&self, parameters: &'p [T]) -> ArrayView2<'p, T> {
        let weights = &parameters[self.weights.clone()];
        ArrayView2::from_shape((self.inputs, self.outputs), weights).expect("its own shape")
    }
}
