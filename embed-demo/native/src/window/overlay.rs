//! Text over a picture.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_8X13;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::text::{Baseline, Text};

const FONT: &MonoFont<'_> = &FONT_8X13;
/// Room around the text, pixels of the font.
const MARGIN: u32 = 5;
const WHITE: u32 = 0x00ff_ffff;

/// Pixels to write on, each `factor` pixels of the screen wide and high.
struct Screen<'p> {
    pixels: &'p mut [u32],
    size: [u32; 2],
    factor: u32,
}

impl Screen<'_> {
    /// Changes the pixels of the screen under a pixel of the font.
    fn each(&mut self, x: u32, y: u32, change: impl Fn(&mut u32)) {
        let [width, height] = self.size;
        let span = |at: u32, end: u32| {
            (at.saturating_mul(self.factor)..(at + 1).saturating_mul(self.factor).min(end))
                .map(|v| v as usize)
        };
        for y in span(y, height) {
            for x in span(x, width) {
                change(&mut self.pixels[y * width as usize + x]);
            }
        }
    }
}

impl OriginDimensions for Screen<'_> {
    fn size(&self) -> Size {
        Size::new(self.size[0] / self.factor, self.size[1] / self.factor)
    }
}

impl DrawTarget for Screen<'_> {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<BinaryColor>>,
    {
        for Pixel(Point { x, y }, color) in pixels {
            if let (Ok(x), Ok(y), true) = (u32::try_from(x), u32::try_from(y), color.is_on()) {
                self.each(x, y, |pixel| *pixel = WHITE);
            }
        }
        Ok(())
    }
}

/// Writes lines over a darkened panel in the upper left corner of a picture of this size.
/// A pixel of the font is `factor` pixels of the screen wide and high.
pub fn draw(pixels: &mut [u32], size: [u32; 2], factor: u32, text: &str) {
    let mut screen = Screen { pixels, size, factor: factor.max(1) };
    let columns = text.lines().map(|line| line.chars().count()).max().unwrap_or(0) as u32;
    let rows = text.lines().count() as u32;
    let character = FONT.character_size;
    let panel = [columns * character.width + 2 * MARGIN, rows * character.height + 2 * MARGIN];
    for y in 0..panel[1] {
        for x in 0..panel[0] {
            screen.each(x, y, |pixel| *pixel = *pixel >> 2 & 0x003f_3f3f);
        }
    }
    let corner = Point::new(MARGIN as i32, MARGIN as i32);
    let style = MonoTextStyle::new(FONT, BinaryColor::On);
    let Ok(_) = Text::with_baseline(text, corner, style, Baseline::Top).draw(&mut screen);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writes_in_the_corner_and_nowhere_else() {
        let mut pixels = vec![0x0080_8080; 100 * 60];
        draw(&mut pixels, [100, 60], 1, "I");
        let is_panel = |i: usize| i % 100 < 18 && i / 100 < 23;
        for (i, pixel) in pixels.iter().enumerate() {
            match is_panel(i) {
                true => assert!([0x0020_2020, WHITE].contains(pixel)),
                false => assert_eq!(*pixel, 0x0080_8080),
            }
        }
        assert!(pixels.contains(&WHITE));
    }

    #[test]
    fn larger_on_a_finer_screen_and_cut_off_on_a_small_one() {
        let count = |factor| {
            let mut pixels = vec![0; 200 * 100];
            draw(&mut pixels, [200, 100], factor, "pocket");
            pixels.iter().filter(|pixel| **pixel == WHITE).count()
        };
        assert_eq!(count(2), 4 * count(1));
        draw(&mut [0; 6], [3, 2], 1, "a\nlong text, and more");
        draw(&mut [], [0, 0], 3, "none");
    }
}
