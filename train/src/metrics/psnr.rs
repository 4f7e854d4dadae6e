//! Peak signal-to-noise ratio.

/// −10 log₁₀ of the mean squared difference over all pixels and channels, both
/// on a scale of 0..1, in dB. Infinite for equal pictures (JSON writes `null`).
///
/// A figure for many views is the mean of each view's PSNR.
///
/// # Panics
/// If the pictures differ in size or are empty.
#[must_use]
pub fn psnr(picture: &[u8], truth: &[u8]) -> f64 {
    assert_eq!(picture.len(), truth.len(), "pictures of one size");
    assert!(!picture.is_empty(), "pictures with pixels");
    let squares: u64 =
        picture.iter().zip(truth).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    let mean = squares as f64 / picture.len() as f64 / (255.0 * 255.0);
    // Not −10 log₁₀, which would give −0 for a mean of 1.
    10.0 * mean.recip().log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hand_computed() {
        // One value of four differs by 51 = 0.2: mean 0.01, so 20 dB.
        assert!((psnr(&[0, 0, 51, 9], &[0, 0, 0, 9]) - 20.0).abs() < 1e-12);
        assert_eq!(psnr(&[0, 0], &[255, 255]), 0.0);
        assert_eq!(psnr(&[1, 2, 3], &[1, 2, 3]), f64::INFINITY);
        assert_eq!(serde_json::to_string(&psnr(&[1], &[1])).unwrap(), "null");
    }
}
