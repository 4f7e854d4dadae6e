//! How far depths are off.

/// How a picture's depths differ from the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthError {
    /// The mean of the absolute differences where both are finite, scene units; `None`
    /// where they nowhere are.
    pub mean: Option<f64>,
    /// The share of pixels, 0 to 1, where one of both is finite and the other is not:
    /// something where there should be nothing, or the other way round.
    pub missed: f64,
}

/// Compares depths, Euclidean distances from the camera in scene units, infinite (or NaN)
/// where nothing is. Pixels whose byte of `mask` is 0 do not count; `None` where none does.
///
/// # Panics
/// If the pictures, or the mask, differ in size.
#[must_use]
pub fn depth_error(picture: &[f32], truth: &[f32], mask: Option<&[u8]>) -> Option<DepthError> {
    assert_eq!(picture.len(), truth.len(), "pictures of one size");
    assert!(mask.is_none_or(|mask| mask.len() == truth.len()), "a mask of the pictures' size");
    let counts = |i: usize| mask.is_none_or(|mask| mask[i] != 0);
    let (mut pixels, mut missed, mut both, mut sum) = (0_u64, 0_u64, 0_u64, 0.0);
    for (i, (&ours, &theirs)) in picture.iter().zip(truth).enumerate() {
        if !counts(i) {
            continue;
        }
        pixels += 1;
        match (ours.is_finite(), theirs.is_finite()) {
            (true, true) => {
                both += 1;
                sum += (f64::from(ours) - f64::from(theirs)).abs();
            }
            (false, false) => {}
            _ => missed += 1,
        }
    }
    let mean = (both > 0).then(|| sum / both as f64);
    (pixels > 0).then(|| DepthError { mean, missed: missed as f64 / pixels as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f32 = f32::INFINITY;

    #[test]
    fn hand_computed() {
        // Off by 0.5 and 1; right about nothing; one thing too many and one too few.
        let ours = [1.5, 3.0, NONE, 2.0, NONE];
        let truth = [1.0, 4.0, NONE, NONE, 7.0];
        let expected = DepthError { mean: Some(0.75), missed: 0.4 };
        assert_eq!(depth_error(&ours, &truth, None), Some(expected));
        // Without the second and the last.
        let expected = DepthError { mean: Some(0.5), missed: 1.0 / 3.0 };
        assert_eq!(depth_error(&ours, &truth, Some(&[1, 0, 9, 255, 0])), Some(expected));
    }

    #[test]
    fn nothing_to_compare() {
        let all_missed = DepthError { mean: None, missed: 1.0 };
        assert_eq!(depth_error(&[NONE, f32::NAN], &[1.0, 2.0], None), Some(all_missed));
        assert_eq!(depth_error(&[1.0], &[1.0], Some(&[0])), None);
        assert_eq!(depth_error(&[], &[], None), None);
    }
}
