//! Rendered pixels to what a screen or an image file wants. Every host goes through here,
//! so the same picture has the same bytes wherever it is shown.
//!
//! Floating-point colours are in the model's own [`ColorSpace`], and so is the background
//! they are composited over. Bytes are always sRGB: colours of a linear model are encoded
//! with the sRGB transfer function after compositing.

use crate::math;
use crate::model::{ColorSpace, Display};

impl Display {
    /// A premultiplied pixel over the background, as 8-bit sRGB.
    ///
    /// ```
    /// use pocketnerf_core::{ColorSpace, Display};
    ///
    /// let srgb = Display { background: [1.0; 3], ..Display::default() };
    /// let linear = Display { color_space: ColorSpace::Linear, ..srgb };
    /// // Half the light of the background shines through.
    /// assert_eq!(srgb.rgb8([0.0, 0.0, 0.0, 0.5]), [128; 3]);
    /// assert_eq!(linear.rgb8([0.0, 0.0, 0.0, 0.5]), [188; 3]);
    /// ```
    #[inline]
    #[must_use]
    pub fn rgb8(&self, pixel: [f32; 4]) -> [u8; 3] {
        rgb8(over(pixel, self.background), self.color_space)
    }

    /// The background in sRGB.
    #[must_use]
    pub fn srgb_background(&self) -> [f32; 3] {
        self.color_space.to_srgb(self.background)
    }
}

impl ColorSpace {
    /// A colour of this space in sRGB.
    #[inline]
    #[must_use]
    pub fn to_srgb(self, rgb: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Srgb => rgb,
            Self::Linear => rgb.map(encode),
        }
    }

    /// An sRGB colour in this space.
    #[must_use]
    pub fn from_srgb(self, rgb: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Srgb => rgb,
            Self::Linear => rgb.map(decode),
        }
    }
}

/// A premultiplied pixel over an opaque background of the same colour space.
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

/// A colour as 8-bit sRGB: each channel is clamped to 0..1 and rounded to the nearest;
/// NaN becomes 0.
#[inline]
#[must_use]
pub fn rgb8(rgb: [f32; 3], space: ColorSpace) -> [u8; 3] {
    space.to_srgb(rgb).map(quantize)
}

/// The same with alpha, which is linear in every space. In a premultiplied pixel of a
/// linear model, the products are encoded: an sRGB texture decodes them before blending.
#[inline]
#[must_use]
pub fn rgba8([r, g, b, a]: [f32; 4], space: ColorSpace) -> [u8; 4] {
    let [r, g, b] = rgb8([r, g, b], space);
    [r, g, b, quantize(a)]
}

fn quantize(x: f32) -> u8 {
    // A cast cuts off, and takes NaN to 0.
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The sRGB transfer function (IEC 61966-2-1): linear light to the encoded value.
fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * math::exp(math::ln(x) / 2.4) - 0.055 }
}

/// The inverse of [`encode`].
fn decode(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { math::exp(2.4 * math::ln((x + 0.055) / 1.055)) }
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
            assert_eq!(rgba8([x; 4], ColorSpace::Srgb), [byte; 4], "{x}");
        }
        // All bytes come back.
        for byte in 0..=255 {
            assert_eq!(rgb8([f32::from(byte) / 255.0; 3], ColorSpace::Srgb), [byte; 3]);
        }
    }

    #[test]
    fn linear_bytes_by_hand() {
        // 1.055 * x^(1/2.4) - 0.055, and 12.92 * x near black; alpha stays as it is.
        let cases = [
            (0.0, 0),
            (0.001, 3),
            (0.003, 10),
            (0.01, 25),
            (0.18, 118),
            (0.215_9, 128),
            (0.5, 188),
            (1.0, 255),
            (-3.0, 0),
            (f32::INFINITY, 255),
            (f32::NAN, 0),
        ];
        for (x, byte) in cases {
            assert_eq!(rgba8([x, x, x, 0.5], ColorSpace::Linear), [byte, byte, byte, 128], "{x}");
        }
    }

    #[test]
    fn every_byte_comes_back_from_linear_light() {
        let linear = ColorSpace::Linear;
        for byte in 0..=255 {
            let light = linear.from_srgb([f32::from(byte) / 255.0; 3]);
            assert_eq!(rgb8(light, linear), [byte; 3]);
        }
        assert_eq!(ColorSpace::Srgb.from_srgb([0.1, 0.5, 2.0]), [0.1, 0.5, 2.0]);
    }

    #[test]
    fn a_linear_background_is_mixed_in_linear_light() {
        // Half of white light: 0.5, encoded 188; encoded white halved would be 128.
        let display = Display {
            background: [1.0, 0.25, 0.0],
            color_space: ColorSpace::Linear,
            ..Display::default()
        };
        // 0.5 + 0.5 * (1, 0.25, 0) = (1, 0.625, 0.5).
        assert_eq!(display.rgb8([0.5, 0.5, 0.5, 0.5]), [255, 207, 188]);
        let [white, quarter, black] = display.srgb_background();
        assert!((white - 1.0).abs() < 1e-6 && (quarter - 0.537_099).abs() < 1e-6 && black == 0.0);
    }
}
