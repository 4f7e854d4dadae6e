//! Structural similarity at several scales.

use super::mask::Mask;
use super::window::{WINDOW, rows, unit};

/// The exponents of the scales, from the finest to the coarsest.
const WEIGHTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];

/// The multi-scale structural similarity of two 8-bit RGB pictures: contrast and structure
/// at five scales and luminance at the coarsest, through the window of
/// [`ssim`](super::ssim), whole windows only; per channel, then the mean over the channels.
///
/// A scale is the mean of 2×2 pixels of the one before; the last row or column of an odd
/// picture is taken twice, as if mirrored. What is inverted (less than 0) counts as 0. `None`
/// where a side has less than 176 pixels, which is a window at the coarsest scale.
///
/// Wang, Simoncelli, Bovik: Multiscale structural similarity for image quality assessment,
/// 2003, equation 7 and the weights of section 3.2.
///
/// # Panics
/// If a picture does not hold `width * height * 3` values.
#[must_use]
pub fn ms_ssim(picture: &[u8], truth: &[u8], width: usize, height: usize) -> Option<f64> {
    masked_ms_ssim([picture, truth], [width, height], &Mask::NONE)
}

/// The same of the windows whose middle counts; `None` where a scale has none.
pub(super) fn masked_ms_ssim(
    [picture, truth]: [&[u8]; 2],
    [width, height]: [usize; 2],
    mask: &Mask<'_>,
) -> Option<f64> {
    assert_eq!([picture.len(), truth.len()], [width * height * 3; 2], "RGB pictures of that size");
    let least = WINDOW << (WEIGHTS.len() - 1);
    if width < least || height < least {
        return None;
    }
    let mut scale = Scale { values: [unit(picture), unit(truth)], width, height };
    let mut channels = [1.0; 3];
    for (i, weight) in WEIGHTS.into_iter().enumerate() {
        let [structure, whole] = scale.similarities(mask)?;
        let factors = if i + 1 < WEIGHTS.len() { structure } else { whole };
        for (channel, factor) in channels.iter_mut().zip(factors) {
            *channel *= factor.max(0.0).powf(weight);
        }
        if i + 1 < WEIGHTS.len() {
            scale = scale.halved();
        }
    }
    Some(channels.iter().sum::<f64>() / 3.0)
}

/// Both pictures at a scale, in 0..1.
struct Scale {
    values: [Vec<f32>; 2],
    width: usize,
    height: usize,
}

impl Scale {
    /// Each channel's mean structure, and its mean similarity.
    fn similarities(&self, mask: &Mask<'_>) -> Option<[[f64; 3]; 2]> {
        let [x, y] = &self.values;
        let size = [self.width, self.height];
        let sums = rows([x, y], self.width * 3, |y, moments| {
            let (mut sums, mut n) = ([[0.0; 3]; 2], 0);
            for (i, window) in moments.similarities().enumerate() {
                if mask.counts([i / 3 + WINDOW / 2, y], size) {
                    sums[0][i % 3] += f64::from(window.structure);
                    sums[1][i % 3] += f64::from(window.whole);
                    n += 1;
                }
            }
            (sums, n / 3)
        });
        let windows: usize = sums.iter().map(|(_, n)| n).sum();
        let sum = |kind: usize, c: usize| sums.iter().map(|(row, _)| row[kind][c]).sum::<f64>();
        (windows > 0).then(|| [0, 1].map(|kind| [0, 1, 2].map(|c| sum(kind, c) / windows as f64)))
    }

    fn halved(&self) -> Self {
        let Self { values, width, height } = self;
        let values = values.each_ref().map(|values| halved(values, *width, *height));
        Self { values, width: width.div_ceil(2), height: height.div_ceil(2) }
    }
}

/// The means of 2×2 pixels.
fn halved(values: &[f32], width: usize, height: usize) -> Vec<f32> {
    let mut means = Vec::with_capacity(width.div_ceil(2) * height.div_ceil(2) * 3);
    for y in (0..height).step_by(2) {
        for x in (0..width).step_by(2) {
            let [right, below] = [(x + 1).min(width - 1), (y + 1).min(height - 1)];
            for c in 0..3 {
                let at = |x: usize, y: usize| values[(y * width + x) * 3 + c];
                means.push((at(x, y) + at(right, y) + at(x, below) + at(right, below)) / 4.0);
            }
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::patterns::{Make, bright, inverted, patterns, soft};

    #[test]
    fn as_pytorch_msssim_says() {
        let cases: [(Make, _, _, _); 4] = [
            (patterns, 176, 192, 0.957_647_170),
            (bright, 208, 176, 0.997_929_901),
            (soft, 256, 176, 0.499_674_230),
            (inverted, 176, 176, 0.0),
        ];
        for (make, width, height, expected) in cases {
            let (a, b) = make(width, height);
            let found = ms_ssim(&a, &b, width, height).unwrap();
            println!("{width}x{height}: {found:.9}, {:.1e} from pytorch_msssim", found - expected);
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn equal_pictures_and_small_pictures() {
        let (a, b) = patterns(181, 177);
        let equal = ms_ssim(&a, &a, 181, 177).unwrap();
        assert!((equal - 1.0).abs() < 1e-6, "{equal}");
        assert!(ms_ssim(&a, &b, 181, 177).is_some());
        let small = 175 * 181 * 3;
        assert_eq!(ms_ssim(&a[..small], &b[..small], 181, 175), None);
    }

    #[test]
    fn odd_sides_are_mirrored() {
        let of_one_channel =
            |values: &[f32]| values.iter().flat_map(|&v| [v; 3]).collect::<Vec<_>>();
        let picture = of_one_channel(&[0.0, 4.0, 8.0, 8.0, 0.0, 4.0, 2.0, 6.0, 1.0]);
        assert_eq!(halved(&picture, 3, 3), of_one_channel(&[3.0, 6.0, 4.0, 1.0]));
    }
}
