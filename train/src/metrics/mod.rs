//! How close a picture is to the truth.
//!
//! Both pictures are 8-bit RGB: what an image file can hold, so that anyone can
//! measure again from the files.
//! [`Metrics::compare`] measures all there is to measure; depths are [`depth_error`]'s,
//! and what is far away is [`psnr_far_near`]'s.

mod depth;
pub(crate) mod exposure;
mod far;
mod lpips;
mod mask;
mod ms_ssim;
#[cfg(test)]
mod patterns;
mod psnr;
mod quantile;
mod scores;
mod ssim;
mod window;

pub use depth::{DepthError, depth_error};
pub use far::psnr_far_near;
pub use lpips::{Lpips, LpipsError};
pub use ms_ssim::ms_ssim;
use pocketnerf_core::{ColorSpace, pixel};
pub use psnr::psnr;
pub use quantile::{mean, median, quantile};
pub(crate) use scores::masked;
pub use scores::{Metrics, Scores};
pub use ssim::ssim;

/// An sRGB picture, three values a pixel, as bytes.
///
/// # Panics
/// If `values` does not hold whole pixels.
#[must_use]
pub fn quantize_all(values: &[f32]) -> Vec<u8> {
    let (pixels, rest) = values.as_chunks::<3>();
    assert!(rest.is_empty(), "{} values are not whole RGB pixels", values.len());
    pixels.iter().flat_map(|rgb| pixel::rgb8(*rgb, ColorSpace::Srgb)).collect()
}

/// Lays straight (not premultiplied) 8-bit RGBA over a background: RGB in
/// 0..1, three values a pixel.
///
/// # Panics
/// If `rgba` does not hold whole pixels.
#[must_use]
pub fn composite_on(rgba: &[u8], background: [f32; 3]) -> Vec<f32> {
    let (pixels, rest) = rgba.as_chunks::<4>();
    assert!(rest.is_empty(), "{} values are not whole RGBA pixels", rgba.len());
    pixels
        .iter()
        .flat_map(|&[r, g, b, a]| {
            let alpha = f32::from(a) / 255.0;
            let over = |c: u8, back: f32| f32::from(c) / 255.0 * alpha + back * (1.0 - alpha);
            [over(r, background[0]), over(g, background[1]), over(b, background[2])]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rounding_rule() {
        let given = [-1.0, 0.0, 0.5 / 255.0, 0.49 / 255.0, 0.5, 1.0, 7.0, f32::NAN, 0.0];
        assert_eq!(quantize_all(&given), [0, 0, 1, 0, 128, 255, 255, 0, 0]);
        for value in 0..=255 {
            assert_eq!(quantize_all(&[f32::from(value) / 255.0; 3]), [value; 3]);
        }
    }

    #[test]
    fn straight_alpha_over_a_background() {
        let rgba = [255, 0, 51, 255, 10, 20, 30, 0, 255, 0, 0, 51];
        let rgb = composite_on(&rgba, [1.0, 0.5, 0.0]);
        let expected = [1.0, 0.0, 0.2, 1.0, 0.5, 0.0, 1.0, 0.4, 0.0];
        for (a, b) in rgb.iter().zip(expected) {
            assert!((a - b).abs() < 1e-6, "{rgb:?}");
        }
    }
}
