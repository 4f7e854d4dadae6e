//! Structural similarity.

use super::mask::Mask;
use super::window::{WINDOW, rows, unit};

/// The mean structural similarity of two 8-bit RGB pictures: 11×11 Gaussian
/// window, sigma 1.5, data range 1, mean over the channels. Only whole windows
/// count, as in scikit-image's `structural_similarity`; a picture narrower or
/// lower than 11 pixels has none.
///
/// Wang, Bovik, Sheikh, Simoncelli: Image quality assessment: from error visibility to
/// structural similarity, 2004, equation 13.
///
/// # Panics
/// If a picture does not hold `width * height * 3` values.
#[must_use]
pub fn ssim(picture: &[u8], truth: &[u8], width: usize, height: usize) -> Option<f64> {
    masked_ssim([picture, truth], [width, height], &Mask::NONE)
}

/// The same of the windows whose middle counts; `None` where there is none.
pub(super) fn masked_ssim(
    [picture, truth]: [&[u8]; 2],
    [width, height]: [usize; 2],
    mask: &Mask<'_>,
) -> Option<f64> {
    let stride = width * 3;
    assert_eq!([picture.len(), truth.len()], [stride * height; 2], "RGB pictures of that size");
    if width < WINDOW || height < WINDOW {
        return None;
    }
    let sums = rows([&unit(picture), &unit(truth)], stride, |y, moments| {
        let counts = |i: &usize| mask.counts([i / 3 + WINDOW / 2, y], [width, height]);
        let windows = moments.similarities().enumerate().filter(|(i, _)| counts(i));
        windows.fold((0.0, 0), |(sum, n), (_, window)| (sum + f64::from(window.whole), n + 1))
    });
    let n: usize = sums.iter().map(|(_, n)| n).sum();
    (n > 0).then(|| sums.iter().map(|(sum, _)| sum).sum::<f64>() / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::patterns::{Make, bright, patterns, soft};

    #[test]
    fn as_scikit_image_says() {
        let cases: [(Make, _, _, _, _); 5] = [
            (patterns, 11, 11, 0.587_244_224, 23.718_332_963),
            (patterns, 64, 48, 0.962_045_709, 23.496_207_723),
            (patterns, 37, 90, 0.963_471_660, 23.505_264_881),
            (bright, 80, 60, 0.979_804_622, 42.690_123_165),
            (soft, 192, 176, 0.197_806_119, 12.766_148_735),
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
