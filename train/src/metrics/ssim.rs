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
                moments.sum_of_similarities(&kernel)
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

/// Weighted sums of x, y, x² + y² and xy down the window's rows.
struct Moments {
    sums: [Vec<f32>; 4],
}

impl Moments {
    fn new(stride: usize) -> Self {
        Self { sums: std::array::from_fn(|_| vec![0.0; stride]) }
    }

    /// Sums over [`WINDOW`] rows of both pictures.
    fn fill(&mut self, kernel: &[f32; WINDOW], x: &[f32], y: &[f32]) {
        let [sum_x, sum_y, sum_squares, sum_products] = &mut self.sums;
        let stride = sum_x.len();
        for sum in [&mut *sum_x, &mut *sum_y, &mut *sum_squares, &mut *sum_products] {
            sum.fill(0.0);
        }
        for ((x, y), &k) in x.chunks_exact(stride).zip(y.chunks_exact(stride)).zip(kernel) {
            for (sum, &x) in sum_x.iter_mut().zip(x) {
                *sum += k * x;
            }
            for (sum, &y) in sum_y.iter_mut().zip(y) {
                *sum += k * y;
            }
            for ((sum, &x), &y) in sum_squares.iter_mut().zip(x).zip(y) {
                *sum += k * (x * x + y * y);
            }
            for ((sum, &x), &y) in sum_products.iter_mut().zip(x).zip(y) {
                *sum += k * (x * y);
            }
        }
    }

    /// Finishes the window along the row and adds up the similarities there.
    fn sum_of_similarities(&self, kernel: &[f32; WINDOW]) -> f64 {
        let values = self.sums[0].len() - 3 * (WINDOW - 1);
        let mut total = 0.0;
        for at in 0..values {
            let along = |sum: &[f32]| {
                kernel.iter().zip(sum[at..].iter().step_by(3)).map(|(k, s)| k * s).sum::<f32>()
            };
            let [x, y, squares, products] = self.sums.each_ref().map(|sum| along(sum));
            let (means, mean_squares) = (x * y, x * x + y * y);
            let (covariance, variances) = (products - means, squares - mean_squares);
            let similarity = (2.0 * means + C1) * (2.0 * covariance + C2)
                / ((mean_squares + C1) * (variances + C2));
            total += f64::from(similarity);
        }
        total
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
