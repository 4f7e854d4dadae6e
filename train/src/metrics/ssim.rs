//! Structural similarity.

use rayon::prelude::*;

/// Side of the window in pixels.
const WINDOW: usize = 11;
/// Standard deviation of the window's Gaussian in pixels.
const SIGMA: f32 = 1.5;
/// (0.01 · data range)² and (0.03 · data range)².
const C1: f32 = 1e-4;
const C2: f32 = 9e-4;

/// The mean structural similarity of two 8-bit RGB pictures: 11×11 Gaussian
/// window, sigma 1.5, data range 1, mean over the channels. Only whole windows
/// count, as in scikit-image's `structural_similarity`; a picture narrower or
/// lower than 11 pixels has none.
///
/// # Panics
/// If a picture does not hold `width * height * 3` values.
#[must_use]
pub fn ssim(picture: &[u8], truth: &[u8], width: usize, height: usize) -> Option<f64> {
    let stride = width * 3;
    assert_eq!([picture.len(), truth.len()], [stride * height; 2], "RGB pictures of that size");
    if width < WINDOW || height < WINDOW {
        return None;
    }
    let kernel = gaussian();
    let unit = |values: &[u8]| values.iter().map(|&v| f32::from(v) / 255.0).collect::<Vec<_>>();
    let (x, y) = (unit(picture), unit(truth));
    let rows = height - WINDOW + 1;
    let sums: Vec<f64> = (0..rows)
        .into_par_iter()
        .map_init(
            || Moments::new(stride),
            |moments, row| {
                let lines = row * stride..(row + WINDOW) * stride;
                moments.fill(&kernel, &x[lines.clone()], &y[lines]);
                moments.sum_of_similarities()
            },
        )
        .collect();
    // Summed row after row, so that the number of threads changes nothing.
    Some(sums.iter().sum::<f64>() / (rows * (stride - 3 * (WINDOW - 1))) as f64)
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
struct Moments {
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

    /// Adds up the similarities of the row's windows.
    fn sum_of_similarities(&self) -> f64 {
        let [x, y, squares, products] = &self.whole;
        let windows = x.iter().zip(y).zip(squares.iter().zip(products));
        let similarity = |((&x, &y), (&squares, &products)): ((&f32, &f32), (&f32, &f32))| {
            let (means, mean_squares) = (x * y, x * x + y * y);
            let (covariance, variances) = (products - means, squares - mean_squares);
            (2.0 * means + C1) * (2.0 * covariance + C2) / ((mean_squares + C1) * (variances + C2))
        };
        windows.map(|window| f64::from(similarity(window))).sum()
    }
}

/// Adds terms to sums, as many as there are sums.
fn add(sums: &mut [f32], terms: impl Iterator<Item = f32>) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The patterns of `tests/fixtures/ssim_skimage.py`.
    fn patterns(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for y in 0..height {
            for x in 0..width {
                for c in 0..3 {
                    let value = (x * x + 3 * y * y + 5 * x * y + 40 * c) / 7 % 256;
                    a.push(value as u8);
                    let noise = (x * 7919 + y * 104_729 + c * 1_299_709) % 61;
                    b.push((value + noise).saturating_sub(30).min(255) as u8);
                }
            }
        }
        (a, b)
    }

    /// Nearly white and smooth: where the variances are small differences.
    fn bright(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for y in 0..height {
            for x in 0..width {
                for c in 0..3 {
                    let value = 250 + (x / 5 + y / 7 + c) % 6;
                    a.push(value as u8);
                    b.push((value - (x * 3 + y) % 4) as u8);
                }
            }
        }
        (a, b)
    }

    #[test]
    fn as_scikit_image_says() {
        type Make = fn(usize, usize) -> (Vec<u8>, Vec<u8>);
        let cases: [(Make, _, _, _, _); 4] = [
            (patterns, 11, 11, 0.587_244_224, 23.718_332_963),
            (patterns, 64, 48, 0.962_045_709, 23.496_207_723),
            (patterns, 37, 90, 0.963_471_660, 23.505_264_881),
            (bright, 80, 60, 0.979_804_622, 42.690_123_165),
        ];
        for (make, width, height, expected, expected_psnr) in cases {
            let (a, b) = make(width, height);
            let found = ssim(&a, &b, width, height).unwrap();
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
            let found = crate::metrics::psnr(&a, &b);
            assert!((found - expected_psnr).abs() < 1e-8, "{found} {expected_psnr}");
        }
    }

    #[test]
    fn equal_pictures_and_small_pictures() {
        let (a, _) = patterns(16, 12);
        assert_eq!(ssim(&a, &a, 16, 12), Some(1.0));
        assert_eq!(ssim(&a[..30 * 12], &a[..30 * 12], 10, 12), None);
    }
}
