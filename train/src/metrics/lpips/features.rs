//! Features of a picture, and what makes the next ones of them.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

use super::network::Shape;
use super::weights::Convolution;

/// The mean and deviation of the pictures that the networks learnt from, on a scale of
/// -1..1.
pub(super) const SHIFT: [f32; 3] = [-0.030, -0.088, -0.188];
pub(super) const SCALE: [f32; 3] = [0.458, 0.448, 0.450];

/// Numbers that a thread lays out for one product, about: 4 MB. Each product reads the whole
/// kernel again, so that smaller bands take longer.
const BAND: usize = 1 << 20;

/// Channels of every pixel, pixel after pixel, row after row.
#[derive(Debug)]
pub(super) struct Features {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) channels: usize,
    pub(super) values: Vec<f32>,
}

impl Features {
    /// Of an 8-bit RGB picture, on the scale of what the networks learnt from.
    pub(super) fn of_picture(rgb: &[u8], width: usize, height: usize) -> Self {
        let value = |(i, &value): (usize, &u8)| {
            (f32::from(value) / 127.5 - 1.0 - SHIFT[i % 3]) / SCALE[i % 3]
        };
        Self { width, height, channels: 3, values: rgb.iter().enumerate().map(value).collect() }
    }

    /// The convolution, and what is less than 0 made 0; `None` where the kernel is larger
    /// than the picture.
    ///
    /// Bands of rows, whose height depends on the shapes alone, become matrices, a row for
    /// each output pixel with all that its kernel covers.
    pub(super) fn convolved(&self, shape: &Shape, convolution: &Convolution) -> Option<Self> {
        let out = |side: usize| {
            Some((side + 2 * shape.padding).checked_sub(shape.side)? / shape.stride + 1)
        };
        let (width, height) = (out(self.width)?, out(self.height)?);
        let covered = shape.side * shape.side * shape.from;
        let kernel = ArrayView2::from_shape((covered, shape.to), &convolution.kernel).ok()?;
        let band = (BAND / (covered * width)).clamp(1, height);
        let mut values = vec![0.0; width * height * shape.to];
        values.par_chunks_mut(band * width * shape.to).enumerate().for_each_init(
            || vec![0.0; band * width * covered],
            |patches, (i, out)| {
                let rows = out.len() / (width * shape.to);
                let patches = &mut patches[..rows * width * covered];
                self.lay_out(shape, i * band, width, patches);
                out.chunks_exact_mut(shape.to).for_each(|o| o.copy_from_slice(&convolution.bias));
                multiply(patches, kernel, out);
                out.iter_mut().for_each(|o| *o = o.max(0.0));
            },
        );
        Some(Self { width, height, channels: shape.to, values })
    }

    /// For each output pixel of a band of rows, from the row `first` on, what its kernel
    /// covers: row after row, pixel after pixel, zeros beyond the picture.
    fn lay_out(&self, shape: &Shape, first: usize, width: usize, patches: &mut [f32]) {
        let line = shape.side * shape.from;
        for (i, line) in patches.chunks_exact_mut(line).enumerate() {
            let (pixel, dy) = (i / shape.side, i % shape.side);
            let y = ((first + pixel / width) * shape.stride + dy).checked_sub(shape.padding);
            let Some(y) = y.filter(|y| *y < self.height) else {
                line.fill(0.0);
                continue;
            };
            // Columns of the picture with its padding.
            let left = pixel % width * shape.stride;
            let start = left.max(shape.padding);
            let end = (left + shape.side).min(self.width + shape.padding).max(start);
            let (before, rest) = line.split_at_mut((start - left) * shape.from);
            let (inside, after) = rest.split_at_mut((end - start) * shape.from);
            before.fill(0.0);
            after.fill(0.0);
            let from = (y * self.width + start - shape.padding) * shape.from;
            inside.copy_from_slice(&self.values[from..][..inside.len()]);
        }
    }

    /// The largest value of each channel in squares of `side` pixels, every second pixel,
    /// whole squares only; `None` where there is none.
    pub(super) fn pooled(&self, side: usize) -> Option<Self> {
        let out = |n: usize| Some(n.checked_sub(side)? / 2 + 1);
        let (width, height, channels) = (out(self.width)?, out(self.height)?, self.channels);
        let mut values = vec![0.0_f32; width * height * channels];
        values.par_chunks_mut(width * channels).enumerate().for_each(|(y, row)| {
            for (x, largest) in row.chunks_exact_mut(channels).enumerate() {
                for (dy, dx) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dy, dx))) {
                    let from = ((2 * y + dy) * self.width + 2 * x + dx) * channels;
                    // Nothing is less than the 0 that this begins with.
                    let values = largest.iter_mut().zip(&self.values[from..]);
                    values.for_each(|(largest, value)| *largest = largest.max(*value));
                }
            }
        });
        Some(Self { width, height, channels, values })
    }
}

/// Adds the product of the rows of `patches` with the kernel to `out`.
fn multiply(patches: &[f32], kernel: ArrayView2<'_, f32>, out: &mut [f32]) {
    let (covered, channels) = kernel.dim();
    let rows = out.len() / channels;
    let patches = ArrayView2::from_shape((rows, covered), patches);
    let out = ArrayViewMut2::from_shape((rows, channels), out);
    let (Ok(patches), Ok(mut out)) = (patches, out) else { unreachable!("whole rows") };
    general_mat_mul(1.0, &patches, &kernel, 1.0, &mut out);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every output pixel by the definition, one product after another.
    fn plainly(of: &Features, shape: &Shape, convolution: &Convolution, at: [usize; 3]) -> f32 {
        let [x, y, to] = at;
        let mut sum = convolution.bias[to];
        for dy in 0..shape.side {
            for dx in 0..shape.side {
                let px = (x * shape.stride + dx).checked_sub(shape.padding);
                let py = (y * shape.stride + dy).checked_sub(shape.padding);
                let (Some(px), Some(py)) = (px, py) else { continue };
                if px >= of.width || py >= of.height {
                    continue;
                }
                for from in 0..shape.from {
                    let value = of.values[(py * of.width + px) * shape.from + from];
                    let weight = ((dy * shape.side + dx) * shape.from + from) * shape.to + to;
                    sum += value * convolution.kernel[weight];
                }
            }
        }
        sum.max(0.0)
    }

    #[test]
    fn convolutions_by_the_definition() {
        let numbers =
            |n: usize| (0..n).map(|i| (i * 37 % 19) as f32 / 9.0 - 1.0).collect::<Vec<_>>();
        // Wider than the kernel, narrower, strided and not.
        let sizes = [(9, 7), (1, 2), (13, 4)];
        for (side, stride, padding) in [(3, 1, 1), (5, 1, 2), (5, 4, 2), (3, 2, 0)] {
            let shape = Shape { side, stride, padding, from: 2, to: 3 };
            let convolution = Convolution { kernel: numbers(side * side * 6), bias: numbers(3) };
            for (width, height) in sizes {
                let values = numbers(width * height * 2);
                let features = Features { width, height, channels: 2, values };
                let Some(found) = features.convolved(&shape, &convolution) else {
                    assert!(width.min(height) + 2 * padding < side);
                    continue;
                };
                for (i, value) in found.values.iter().enumerate() {
                    let at = [i / 3 % found.width, i / 3 / found.width, i % 3];
                    let expected = plainly(&features, &shape, &convolution, at);
                    assert!((value - expected).abs() < 1e-4, "{value} {expected}");
                }
            }
        }
    }

    #[test]
    fn pooling_takes_whole_squares() {
        let values = vec![1.0, 5.0, 2.0, 9.0, 3.0, 4.0, 0.0, 8.0, 6.0, 7.0];
        let features = Features { width: 5, height: 2, channels: 1, values };
        let pooled = features.pooled(2).unwrap();
        assert_eq!((pooled.width, pooled.height, pooled.values), (2, 1, vec![5.0, 9.0]));
        assert!(features.pooled(3).is_none());
    }
}
