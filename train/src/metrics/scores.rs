//! All metrics of a picture at once.

use std::borrow::Cow;

use serde::Serialize;

use super::{Lpips, ms_ssim, psnr, ssim};

/// What is measured beyond that which needs nothing but the pictures.
#[derive(Debug, Default)]
pub struct Metrics {
    /// Learned perceptual similarity, where its weights are given.
    pub lpips: Option<Lpips>,
}

/// How close a picture is to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// dB, on 8-bit values; `null` for identical pictures.
    pub psnr: f64,
    /// Structural similarity; `null` where the picture is too small.
    pub ssim: Option<f64>,
    /// The same at five scales; `null` where a side has less than 176 pixels.
    pub ms_ssim: Option<f64>,
    /// Perceptual distance, [`Lpips::distance`]; `null` without weights, and where the
    /// picture is too small.
    pub lpips: Option<f64>,
}

impl Metrics {
    /// Compares 8-bit RGB pictures of `size`, width and height.
    ///
    /// Pixels whose byte of `mask` is 0 do not count for PSNR; for the others, whose windows
    /// reach across the mask's edge, the picture is right there by definition.
    ///
    /// # Panics
    /// If a picture or the mask is of another size, or no pixel counts.
    #[must_use]
    pub fn compare(
        &self,
        picture: &[u8],
        truth: &[u8],
        mask: Option<&[u8]>,
        [width, height]: [usize; 2],
    ) -> Scores {
        let ([counted, counted_truth], without) = masked(picture, truth, mask);
        let lpips = self.lpips.as_ref();
        Scores {
            psnr: psnr(&counted, &counted_truth),
            ssim: ssim(&without, truth, width, height),
            ms_ssim: ms_ssim(&without, truth, width, height),
            lpips: lpips.and_then(|lpips| lpips.distance(&without, truth, width, height)),
        }
    }
}

/// What a mask leaves: of picture and truth the pixels that count, one after another,
/// and the picture with the truth in place of the others.
fn masked<'p>(
    picture: &'p [u8],
    truth: &'p [u8],
    mask: Option<&[u8]>,
) -> ([Cow<'p, [u8]>; 2], Cow<'p, [u8]>) {
    let Some(mask) = mask else { return ([picture.into(), truth.into()], picture.into()) };
    let counted = |rgb: &[u8]| {
        let pixels = rgb.as_chunks::<3>().0.iter().zip(mask).filter(|(_, counts)| **counts != 0);
        pixels.flat_map(|(pixel, _)| *pixel).collect::<Vec<u8>>().into()
    };
    let mut without = picture.to_vec();
    let pixels = without.as_chunks_mut::<3>().0.iter_mut().zip(truth.as_chunks::<3>().0);
    let ignored = pixels.zip(mask).filter(|(_, counts)| **counts == 0);
    ignored.for_each(|((ours, theirs), _)| *ours = *theirs);
    ([counted(picture), counted(truth)], without.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_pixels_count_for_nothing() {
        // Three pixels, of which the second is ignored.
        let (ours, truth) = ([0, 51, 0, 200, 200, 200, 9, 9, 9], [0, 0, 0, 1, 2, 3, 9, 9, 9]);
        let ([picture, photograph], without) = masked(&ours, &truth, Some(&[255, 0, 1]));
        assert_eq!(*picture, [0, 51, 0, 9, 9, 9]);
        assert_eq!(*photograph, [0, 0, 0, 9, 9, 9]);
        assert_eq!(*without, [0, 51, 0, 1, 2, 3, 9, 9, 9]);
        // One value of six differs by 0.2: the mean square is 0.04 / 6, 21.76 dB.
        let expected = -10.0 * (0.04f64 / 6.0).log10();
        assert!((psnr(&picture, &photograph) - expected).abs() < 1e-9);
        let ([picture, _], without) = masked(&ours, &truth, None);
        assert_eq!((&*picture, &*without), (&ours[..], &ours[..]));
    }
}
