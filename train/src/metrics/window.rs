//! The Gaussian window that SSIM and MS-SSIM look through.

use rayon::prelude::*;

/// Side of the window in pixels.
pub(super) const WINDOW: usize = 11;
/// Standard deviation of the window's Gaussian in pixels.
const SIGMA: f32 = 1.5;
/// (0.01 · data range)² and (0.03 · data range)².
const C1: f32 = 1e-4;
const C2: f32 = 9e-4;

/// What a window says of two pictures.
#[derive(Clone, Copy)]
pub(super) struct Similarity {
    /// Contrast and structure alone.
    pub(super) structure: f32,
    /// With luminance: SSIM.
    pub(super) whole: f32,
}

/// Sums up each row of whole windows of two RGB pictures, `stride` values a row, in 0..1. The
/// sums come in the order of the rows, whatever the number of threads. `sum` receives the row of
/// the windows' middles.
pub(super) fn rows<T: Send>(
    [x, y]: [&[f32]; 2],
    stride: usize,
    sum: impl Fn(usize, &Moments) -> T + Sync,
) -> Vec<T> {
    let kernel = gaussian();
    let height = x.len() / stride;
    (0..height + 1 - WINDOW)
        .into_par_iter()
        .map_init(
            || Moments::new(stride),
            |moments, row| {
                let lines = row * stride..(row + WINDOW) * stride;
                moments.fill(&kernel, &x[lines.clone()], &y[lines]);
                sum(row + WINDOW / 2, moments)
            },
        )
        .collect()
}

/// An 8-bit picture in 0..1.
pub(super) fn unit(values: &[u8]) -> Vec<f32> {
    values.iter().map(|&v| f32::from(v) / 255.0).collect()
}

/// The window's weights along one side; they sum to 1.
fn gaussian() -> [f32; WINDOW] {
    let half = (WINDOW / 2) as f32;
    let weight = |i: usize| (-0.5 * ((i as f32 - half) / SIGMA).powi(2)).exp();
    let weights: [f32; WINDOW] = std::array::from_fn(weight);
    weights.map(|w| w / weights.iter().sum::<f32>())
}

/// Weighted sums of x, y, x² + y² and xy over a window; loops go along the row,
/// so that the compiler turns them into vector instructions.
pub(super) struct Moments {
    /// Down the window's rows: one value for each of the picture's row.
    down: [Vec<f32>; 4],
    /// Down and along: one value for each whole window.
    whole: [Vec<f32>; 4],
}

impl Moments {
    fn new(stride: usize) -> Self {
        let rows = |length: usize| std::array::from_fn(|_| vec![0.0; length]);
        Self { down: rows(stride), whole: rows(stride - 3 * (WINDOW - 1)) }
    }

    /// Sums over [`WINDOW`] rows of both pictures.
    fn fill(&mut self, kernel: &[f32; WINDOW], x: &[f32], y: &[f32]) {
        let [down_x, down_y, down_squares, down_products] = &mut self.down;
        let stride = down_x.len();
        for sum in [&mut *down_x, &mut *down_y, &mut *down_squares, &mut *down_products] {
            sum.fill(0.0);
        }
        for ((x, y), &k) in x.chunks_exact(stride).zip(y.chunks_exact(stride)).zip(kernel) {
            add(down_x, x.iter().map(|&x| k * x));
            add(down_y, y.iter().map(|&y| k * y));
            add(down_squares, x.iter().zip(y).map(|(&x, &y)| k * (x * x + y * y)));
            add(down_products, x.iter().zip(y).map(|(&x, &y)| k * (x * y)));
        }
        for (whole, down) in self.whole.iter_mut().zip(&self.down) {
            whole.fill(0.0);
            for (tap, &k) in kernel.iter().enumerate() {
                add(whole, down[3 * tap..].iter().map(|&sum| k * sum));
            }
        }
    }

    /// The similarities of the row's windows, channel after channel, pixel after pixel.
    pub(super) fn similarities(&self) -> impl Iterator<Item = Similarity> {
        let [x, y, squares, products] = &self.whole;
        let windows = x.iter().zip(y).zip(squares.iter().zip(products));
        windows.map(|((&x, &y), (&squares, &products))| {
            let (means, mean_squares) = (x * y, x * x + y * y);
            let (covariance, variances) = (products - means, squares - mean_squares);
            let structure = (2.0 * covariance + C2) / (variances + C2);
            let whole = (2.0 * means + C1) * (2.0 * covariance + C2)
                / ((mean_squares + C1) * (variances + C2));
            Similarity { structure, whole }
        })
    }
}

/// Adds terms to sums, as many as there are sums.
fn add(sums: &mut [f32], terms: impl Iterator<Item = f32>) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}
