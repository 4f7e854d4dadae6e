//! The display: the frame buffer that a driver would send to a panel.

use embedded_graphics::Drawable;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::framebuffer::{Framebuffer, buffer_size};
use embedded_graphics::geometry::Point;
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_4X6;
use embedded_graphics::pixelcolor::raw::{BigEndian, RawU24};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::Text;

/// Pixels along a side.
pub(crate) const SIDE: u32 = 64;
const N: usize = SIDE as usize;

/// 64 x 64 pixels of three bytes.
pub(crate) struct Display(
    Framebuffer<Rgb888, RawU24, BigEndian, N, N, { buffer_size::<Rgb888>(N, N) }>,
);

impl Display {
    pub(crate) const fn new() -> Self {
        Self(Framebuffer::new())
    }

    /// Shows a line of pixels of a model.
    pub(crate) fn line(&mut self, y: u32, rgba: &[[f32; 4]], model: &pocketnerf_core::Display) {
        for (x, rgba) in (0..).zip(rgba) {
            let [r, g, b] = model.rgb8(*rgba);
            self.0.set_pixel(Point::new(x, y as i32), Rgb888::new(r, g, b));
        }
    }

    /// Shows an error instead of a picture.
    pub(crate) fn say(&mut self, text: &str) {
        let style = MonoTextStyle::new(&FONT_4X6, Rgb888::WHITE);
        // Drawing into memory cannot fail.
        let _ = self.0.clear(Rgb888::new(160, 0, 0));
        let _ = Text::new(text, Point::new(2, 30), style).draw(&mut self.0);
    }

    /// Red, green and blue of all pixels, row after row.
    pub(crate) const fn bytes(&self) -> &[u8] {
        self.0.data()
    }
}
