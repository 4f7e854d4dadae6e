//! What a pixel holds to what a screen or an image file wants. Every host goes through
//! here, so that the same picture has the same bytes wherever it is shown.

/// A premultiplied pixel over an opaque background.
///
/// ```
/// use pocketnerf_core::pixel;
///
/// // Half of what is behind shines through.
/// assert_eq!(pixel::over([0.5, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0]), [0.5, 0.0, 0.5]);
/// ```
#[inline]
#[must_use]
pub fn over([r, g, b, a]: [f32; 4], background: [f32; 3]) -> [f32; 3] {
    let [br, bg, bb] = background.map(|c| c * (1.0 - a));
    [r + br, g + bg, b + bb]
}

/// A premultiplied pixel with straight alpha, as image files have it. Black where it is
/// fully transparent.
#[inline]
#[must_use]
pub fn straight([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    let color = |c: f32| if a > 0.0 { c / a } else { 0.0 };
    [color(r), color(g), color(b), a]
}

/// A channel in 0..1 as 8 bits: `clamp(x, 0, 1) * 255`, rounded to the nearest; NaN
/// becomes 0.
#[inline]
#[must_use]
pub fn quantize(x: f32) -> u8 {
    // A cast cuts off, and takes NaN to 0.
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_colours_by_hand() {
        assert_eq!(straight([0.25, 0.5, 0.0, 0.5]), [0.5, 1.0, 0.0, 0.5]);
        assert_eq!(straight([0.0; 4]), [0.0; 4]);
    }

    #[test]
    fn bytes_by_hand() {
        let cases =
            [(0.0, 0), (1.0, 255), (-3.0, 0), (7.0, 255), (f32::NAN, 0), (0.5, 128), (0.498, 127)];
        for (x, byte) in cases {
            assert_eq!(quantize(x), byte, "{x}");
        }
        // All bytes come back.
        (0..=255).for_each(|byte| assert_eq!(quantize(f32::from(byte) / 255.0), byte));
    }
}
