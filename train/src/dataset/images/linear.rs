//! Linear colours as an image of eight bits has them.

use image::Rgba32FImage;

/// Straight RGBA with the sRGB curve. EXR's colours are premultiplied with alpha. What is brighter
/// than 1 is cut off, and what is no number is black.
pub(super) fn to_srgb(image: &Rgba32FImage) -> Vec<u8> {
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let pixel = |[r, g, b, alpha]: [f32; 4]| {
        let alpha = if alpha > 0.0 { alpha.min(1.0) } else { 0.0 };
        let straight = |value: f32| if alpha > 0.0 { value / alpha } else { 0.0 };
        let [r, g, b] = [r, g, b].map(|value| byte(encoded(straight(value))));
        [r, g, b, byte(alpha)]
    };
    image.pixels().flat_map(|image::Rgba(rgba)| pixel(*rgba)).collect()
}

/// The sRGB curve (IEC 61966-2-1).
fn encoded(linear: f32) -> f32 {
    if linear.is_nan() {
        return 0.0;
    }
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 0.5 is 1.055 0.5^(1/2.4) - 0.055 = 0.7354, 187.5 of 255; 0.001 is 0.01292, 3.3.
    #[test]
    fn the_curve_and_what_is_outside_it() {
        let pixels = [
            [0.5, 0.001, 0.0, 1.0],
            // Half covered: 0.25 is 0.5 straight.
            [0.25, 0.0, 0.5, 0.5],
            [7.0, f32::NAN, -1.0, 2.0],
            [f32::INFINITY, 1.0, 1.0, f32::NAN],
        ];
        let image = Rgba32FImage::from_raw(2, 2, pixels.concat()).unwrap();
        assert_eq!(to_srgb(&image), [188, 3, 0, 255, 188, 0, 255, 128, 255, 0, 0, 255, 0, 0, 0, 0]);
    }
}
