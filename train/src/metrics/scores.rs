//! All metrics of a picture at once.

use std::borrow::Cow;

use serde::Serialize;

use super::mask::Mask;
use super::ms_ssim::masked_ms_ssim;
use super::ssim::masked_ssim;
use super::{Lpips, psnr};

/// What is measured beyond that which needs nothing but the pictures.
#[derive(Debug, Default)]
pub struct Metrics {
    /// Learned perceptual similarity, where its weights are given.
    pub lpips: Option<Lpips>,
    /// Whether each channel of a picture is multiplied by a factor that is fitted on the left half
    /// of the truth, and the right halves are compared.
    pub fit_exposure: bool,
    /// Whether the pose of each view is fitted to what a model shows, before pictures are compared.
    pub fit_poses: bool,
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
    /// Pixels whose byte of `mask` is 0 do not count: not for PSNR, nor do windows and features
    /// whose middle is such a pixel. Others reach across the mask's edge; there the picture is
    /// right by definition.
    ///
    /// # Panics
    /// If a picture or the mask is of another size, or no pixel counts.
    #[must_use]
    pub fn compare(
        &self,
        picture: &[u8],
        truth: &[u8],
        mask: Option<&[u8]>,
        size: [usize; 2],
    ) -> Scores {
        let ([counted, counted_truth], without) = masked(picture, truth, mask);
        let (pictures, mask) = ([&*without, truth], Mask::new(mask, size));
        let lpips = self.lpips.as_ref();
        Scores {
            psnr: psnr(&counted, &counted_truth),
            ssim: masked_ssim(pictures, size, &mask),
            ms_ssim: masked_ms_ssim(pictures, size, &mask),
            lpips: lpips.and_then(|lpips| lpips.masked_distance(pictures, size, &mask)),
        }
    }
}

/// What a mask leaves: of picture and truth the pixels that count, one after another,
/// and the picture with the truth in place of the others.
pub(crate) fn masked<'p>(
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
    fn what_is_ignored_is_not_perfect() {
        // Wrong alike everywhere: what is ignored, more or less, changes nothing.
        let (width, height) = (200, 190);
        let truth: Vec<u8> = (0..width * height * 3).map(|i| (i * i % 97) as u8).collect();
        let picture: Vec<u8> = truth.iter().map(|v| 200 - v).collect();
        let compare = |mask: Option<&[u8]>| {
            Metrics::default().compare(&picture, &truth, mask, [width, height])
        };
        let all = compare(None);
        let left: Vec<u8> = (0..width * height).map(|i| u8::from(i % width < 60)).collect();
        let masked = compare(Some(&left));
        let [all_ssim, masked_ssim] = [all, masked].map(|scores| scores.ssim.unwrap());
        // But for windows across the edge: 5 of 55 columns, which are half right.
        assert!(all_ssim < 0.0 && masked_ssim < all_ssim + 0.1, "{all_ssim} {masked_ssim}");
        let all_but_one = [&[0][..], &vec![1; width * height - 1]].concat();
        assert!((compare(Some(&all_but_one)).ssim.unwrap() - all_ssim).abs() < 1e-4);
        // No window has its middle in what counts.
        let corner: Vec<u8> = (0..width * height).map(|i| u8::from(i == 0)).collect();
        let corner = compare(Some(&corner));
        assert!(corner.psnr.is_finite() && (corner.ssim, corner.ms_ssim) == (None, None));
    }

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
