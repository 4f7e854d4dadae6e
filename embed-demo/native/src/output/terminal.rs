//! Pictures in a terminal: a character is two pixels, one above the other.

use std::fmt::Write;

use terminal_size::{Height, Width, terminal_size};

use crate::paint::picture::Picture;

/// Columns and rows of the terminal, less a row for the prompt; of 80 by 24 if there is none.
#[must_use]
pub fn room() -> [u32; 2] {
    let [columns, rows] = terminal_size()
        .map_or([80, 24], |(Width(columns), Height(rows))| [columns, rows].map(u32::from));
    [columns.max(1), rows.saturating_sub(1).max(1)]
}

/// The largest picture of this shape that fits into columns and rows.
#[must_use]
pub fn fit([width, height]: [u32; 2], [columns, rows]: [u32; 2]) -> [u32; 2] {
    let [w, h, most_w, most_h] = [width, height, columns, 2 * rows].map(f64::from);
    let scale = (most_w / w).min(most_h / h);
    [w, h].map(|side| ((side * scale).round() as u32).max(1))
}

/// The picture as text: upper half blocks in 24-bit colours, with the pixel below as the
/// background. A last row on its own keeps the terminal's background.
#[must_use]
pub fn text(picture: &Picture) -> String {
    let mut text = String::new();
    let width = picture.width.max(1) as usize;
    let rows: Vec<&[u32]> = picture.pixels.chunks_exact(width).collect();
    for pair in rows.chunks(2) {
        for (x, above) in pair[0].iter().enumerate() {
            color(&mut text, 38, *above);
            if let Some(below) = pair.get(1) {
                color(&mut text, 48, below[x]);
            }
            text.push('▀');
        }
        text.push_str("\x1b[0m\n");
    }
    text
}

/// Sets the foreground (38) or the background (48).
fn color(text: &mut String, which: u32, pixel: u32) {
    let [_, r, g, b] = pixel.to_be_bytes();
    // Writing to a string cannot fail.
    let _ = write!(text, "\x1b[{which};2;{r};{g};{b}m");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::picture::pack;

    #[test]
    fn two_pixels_a_character() {
        let pixels = [[1, 2, 3], [4, 5, 6], [7, 8, 9], [250, 251, 252], [0; 3], [255; 3]].map(pack);
        let picture = Picture { width: 2, height: 3, pixels: pixels.to_vec() };
        let expected = "\x1b[38;2;1;2;3m\x1b[48;2;7;8;9m▀\x1b[38;2;4;5;6m\x1b[48;2;250;251;252m▀\
            \x1b[0m\n\x1b[38;2;0;0;0m▀\x1b[38;2;255;255;255m▀\x1b[0m\n";
        assert_eq!(text(&picture), expected);
        assert_eq!(text(&Picture::default()), "");
    }

    #[test]
    fn fits() {
        assert_eq!(fit([800, 800], [80, 23]), [46, 46]);
        assert_eq!(fit([800, 400], [80, 23]), [80, 40]);
        assert_eq!(fit([1, 10_000], [80, 1]), [1, 2]);
    }
}
