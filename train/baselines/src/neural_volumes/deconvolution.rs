//! Transposed convolution, which doubles the side of a cube: kernels of 4³, strides of 2.

use std::ops::Range;

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

use super::grid::Grid;
use crate::network::{Layout, Real};

/// Values of a kernel, for a channel in and one out.
const KERNEL: usize = 64;
/// Parts that the points of a cube are divided into; sums of gradients follow their order.
const PARTS: usize = 8;

/// One layer.
#[derive(Clone, Debug)]
pub(super) struct Deconvolution {
    inputs: usize,
    outputs: usize,
    weights: Range<usize>,
    biases: Range<usize>,
}

impl Deconvolution {
    pub(super) fn new(layout: &mut Layout, inputs: usize, outputs: usize, gain: f64) -> Self {
        // Eight of the 64 values meet in a point.
        let deviation = gain * (2.0 / (8 * inputs) as f64).sqrt();
        let weights = layout.add(inputs * KERNEL * outputs, 0.0, deviation);
        let biases = layout.add(outputs, 0.0, 0.0);
        Self { inputs, outputs, weights, biases }
    }

    /// A cube with twice the side.
    pub(super) fn forward<T: Real>(&self, parameters: &[T], input: &Grid<T>) -> Grid<T> {
        let columns = KERNEL * self.outputs;
        let points = input.side.pow(3);
        let mut products = vec![T::zero(); points * columns];
        let rows = points.div_ceil(PARTS);
        let weights = self.matrix(parameters);
        products
            .par_chunks_mut(rows * columns)
            .zip(input.values.par_chunks(rows * self.inputs))
            .for_each(|(products, values)| {
                let x = matrix(values, self.inputs);
                let n = x.nrows();
                let mut y = ArrayViewMut2::from_shape((n, columns), products).expect("its shape");
                general_mat_mul(T::one(), &x, &weights, T::zero(), &mut y);
            });
        let mut output = Grid::zeros(2 * input.side, self.outputs);
        let bias = &parameters[self.biases.clone()];
        let row = output.side * self.outputs;
        output.values.par_chunks_mut(row).enumerate().for_each(|(i, values)| {
            values.chunks_mut(self.outputs).for_each(|value| value.copy_from_slice(bias));
            let (y, z) = (i % output.side, i / output.side);
            for (pz, kz) in pairs(z, input.side).into_iter().flatten() {
                for (py, ky) in pairs(y, input.side).into_iter().flatten() {
                    let taps = (kz * 4 + ky) * 4 * self.outputs;
                    for px in 0..input.side {
                        let point = (pz * input.side + py) * input.side + px;
                        let products = &products[point * columns + taps..][..4 * self.outputs];
                        let (reached, skipped) = self.reached(px, input.side);
                        let products = &products[skipped..][..reached.len()];
                        let values = values[reached].iter_mut().zip(products);
                        values.for_each(|(sum, product)| *sum += *product);
                    }
                }
            }
        });
        output
    }

    /// What four neighbouring values of the kernel reach in a row of the result, as a range of its
    /// values, and how many of the kernel's fall before the row.
    fn reached(&self, point: usize, side: usize) -> (Range<usize>, usize) {
        let n = self.outputs;
        let first = (2 * point).saturating_sub(1);
        let end = (2 * point + 3).min(2 * side);
        (first * n..end * n, if point == 0 { n } else { 0 })
    }

    /// Adds to the parameters' gradient, and gives that of the input.
    pub(super) fn backward<T: Real>(
        &self,
        parameters: &[T],
        input: &Grid<T>,
        d: &Grid<T>,
        gradient: &mut [T],
    ) -> Grid<T> {
        let columns = KERNEL * self.outputs;
        let (side, points) = (input.side, input.side.pow(3));
        let rows = points.div_ceil(PARTS);
        let weights = self.matrix(parameters);
        let mut d_input = input.empty();
        let parts = d_input.values.par_chunks_mut(rows * self.inputs);
        let parts = parts.zip(input.values.par_chunks(rows * self.inputs)).enumerate();
        let sums: Vec<Array2<T>> = parts
            .map(|(part, (d_values, values))| {
                let x = matrix(values, self.inputs);
                let first = part * rows;
                let mut gathered = Array2::zeros((x.nrows(), columns));
                for (mut row, point) in gathered.rows_mut().into_iter().zip(first..) {
                    let row = row.as_slice_mut().expect("rows are contiguous");
                    self.gather([point % side, point / side % side, point / side.pow(2)], d, row);
                }
                let mut d_x = ArrayViewMut2::from_shape((x.nrows(), self.inputs), d_values)
                    .expect("its shape");
                general_mat_mul(T::one(), &gathered, &weights.t(), T::zero(), &mut d_x);
                x.t().dot(&gathered)
            })
            .collect();
        let own = &mut gradient[self.weights.clone()];
        for sum in &sums {
            own.iter_mut().zip(sum).for_each(|(g, sum)| *g += *sum);
        }
        let own = &mut gradient[self.biases.clone()];
        for values in d.values.chunks(self.outputs) {
            own.iter_mut().zip(values).for_each(|(g, d)| *g += *d);
        }
        d_input
    }

    /// What a point gets back by each of the kernel's values.
    fn gather<T: Real>(&self, [x, y, z]: [usize; 3], d: &Grid<T>, row: &mut [T]) {
        let along = |at: usize, tap: usize| (2 * at + tap).checked_sub(1).filter(|o| *o < d.side);
        for (taps, row) in row.chunks_mut(4 * self.outputs).enumerate() {
            let (Some(out_y), Some(out_z)) = (along(y, taps % 4), along(z, taps / 4)) else {
                continue;
            };
            let values = &d.values[(out_z * d.side + out_y) * d.side * self.outputs..];
            let (reached, skipped) = self.reached(x, d.side / 2);
            row[skipped..][..reached.len()].copy_from_slice(&values[reached]);
        }
    }

    fn matrix<'p, T>(&self, parameters: &'p [T]) -> ArrayView2<'p, T> {
        let weights = &parameters[self.weights.clone()];
        ArrayView2::from_shape((self.inputs, KERNEL * self.outputs), weights).expect("its shape")
    }
}

/// Values, so many a row.
fn matrix<T>(values: &[T], columns: usize) -> ArrayView2<'_, T> {
    ArrayView2::from_shape((values.len() / columns, columns), values).expect("whole rows")
}

/// Along an axis, the two points and kernel values that make up a point of the result; `None`
/// beyond the cube.
fn pairs(at: usize, side: usize) -> [Option<(usize, usize)>; 2] {
    let half = at / 2;
    let inside = |point: usize, tap| (point < side).then_some((point, tap));
    match at % 2 {
        0 => [inside(half, 1), half.checked_sub(1).map(|point| (point, 3))],
        _ => [inside(half + 1, 0), inside(half, 2)],
    }
}
