//! What is near and what is far, apart.

use super::{masked, psnr};

/// PSNR, dB, of the pixels whose true depth is more than `limit`, and of all others; 8-bit RGB
/// pictures. Depths that are infinite (or NaN) are far. Pixels whose byte of `mask` is 0 do not
/// count; `None` where no pixel does.
///
/// # Panics
/// If the pictures, the depths, or the mask differ in size.
#[must_use]
pub fn psnr_far_near(
    picture: &[u8],
    truth: &[u8],
    depth: &[f32],
    limit: f32,
    mask: Option<&[u8]>,
) -> [Option<f64>; 2] {
    assert_eq!([picture.len(), truth.len()], [3 * depth.len(); 2], "pictures of one size");
    assert!(mask.is_none_or(|mask| mask.len() == depth.len()), "a mask of the pictures' size");
    let counts = |i: usize| mask.is_none_or(|mask| mask[i] != 0);
    let is_far = |t: f32| t.is_nan() || t > limit;
    [true, false].map(|far| {
        let wanted = |(i, t): (usize, &f32)| u8::from(counts(i) && is_far(*t) == far);
        let part: Vec<u8> = depth.iter().enumerate().map(wanted).collect();
        let ([picture, truth], _) = masked(picture, truth, Some(&part));
        (!picture.is_empty()).then(|| psnr(&picture, &truth))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six pixels of which the second, the third, the fifth and the last are far.
    #[test]
    fn hand_computed() {
        let depth = [1.0, f32::INFINITY, 9.5, 9.0, f32::NAN, 100.0];
        let truth = [100; 18];
        let mut picture = truth;
        // Near: one of six values is off by 51, 0.2: the mean square is 0.04 / 6.
        picture[0] = 151;
        // Far: two of twelve.
        picture[4] = 151;
        picture[17] = 49;
        let [far, near] = psnr_far_near(&picture, &truth, &depth, 9.0, None).map(Option::unwrap);
        assert!((near - 10.0 * (6.0_f64 / 0.04).log10()).abs() < 1e-9, "{near}");
        assert!((far - 10.0 * (12.0_f64 / 0.08).log10()).abs() < 1e-9, "{far}");
        // Without the second, one of nine far values is off.
        let mask = [1, 0, 1, 1, 1, 1];
        let [far, same] = psnr_far_near(&picture, &truth, &depth, 9.0, Some(&mask));
        assert!((far.unwrap() - 10.0 * (9.0_f64 / 0.04).log10()).abs() < 1e-9, "{far:?}");
        assert_eq!(same, Some(near));
    }

    #[test]
    fn nothing_far_and_nothing_near() {
        let [far, near] = psnr_far_near(&[7; 3], &[7; 3], &[2.0], 3.0, None);
        assert_eq!((far, near), (None, Some(f64::INFINITY)));
        let [far, near] = psnr_far_near(&[0; 3], &[255; 3], &[4.0], 3.0, None);
        assert_eq!((far, near), (Some(0.0), None));
        assert_eq!(psnr_far_near(&[0; 3], &[0; 3], &[4.0], 3.0, Some(&[0])), [None; 2]);
    }
}
