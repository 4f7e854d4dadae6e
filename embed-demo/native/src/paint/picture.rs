//! A picture in the pixel format of the screen.

use pocketnerf_core::Tile;
use rayon::prelude::*;

/// Pixels of 32 bits: 0, red, green, blue from the highest byte to the lowest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Row after row.
    pub pixels: Vec<u32>,
}

/// Three bytes as one pixel.
#[must_use]
pub const fn pack([r, g, b]: [u8; 3]) -> u32 {
    u32::from_be_bytes([0, r, g, b])
}

impl Picture {
    /// A black picture.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![0; width as usize * height as usize] }
    }

    /// Red, green and blue of every pixel.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|pixel| pixel.to_be_bytes().into_iter().skip(1)).collect()
    }

    /// Copies a tile to its place.
    pub fn put(&mut self, tile: Tile, pixels: &[u32]) {
        let Tile { x, y, width, .. } = tile;
        let rows = self.pixels.chunks_exact_mut(self.width.max(1) as usize).skip(y as usize);
        for (row, from) in rows.zip(pixels.chunks_exact(width.max(1) as usize)) {
            row[x as usize..][..from.len()].copy_from_slice(from);
        }
    }

    /// Scales this picture to fill `to`, interpolating bilinearly; a picture of the same size
    /// is copied.
    pub fn enlarge(&self, to: &mut Self) {
        if [self.width, self.height] == [to.width, to.height] {
            to.pixels.copy_from_slice(&self.pixels);
            return;
        }
        if self.pixels.is_empty() || to.pixels.is_empty() {
            return;
        }
        let (width, from) = (self.width as usize, &self.pixels);
        let columns = stops(self.width, to.width);
        let rows = stops(self.height, to.height);
        to.pixels.par_chunks_exact_mut(columns.len()).zip(rows).for_each(
            |(row, [y0, y1, down])| {
                let [above, below] = [y0, y1].map(|y| &from[y as usize * width..][..width]);
                for (pixel, [x0, x1, right]) in row.iter_mut().zip(&columns) {
                    let at = |row: &[u32]| mix(row[*x0 as usize], row[*x1 as usize], *right);
                    *pixel = mix(at(above), at(below), down);
                }
            },
        );
    }

    /// PSNR against another picture, dB; `None` if the two are equal or differ in size.
    #[must_use]
    pub fn psnr(&self, other: &Self) -> Option<f32> {
        if [self.width, self.height] != [other.width, other.height] || self == other {
            return None;
        }
        let square = |(a, b): (&u32, &u32)| {
            let channels = a.to_be_bytes().into_iter().zip(b.to_be_bytes());
            channels.map(|(a, b)| u64::from(a.abs_diff(b)).pow(2)).sum::<u64>()
        };
        let sum: u64 = self.pixels.par_iter().zip(&other.pixels).map(square).sum();
        let mean = sum as f64 / (3 * self.pixels.len()) as f64;
        Some((10.0 * (255.0 * 255.0 / mean).log10()) as f32)
    }
}

/// For each of `to` pixels in a row: the two of `from` pixels that it lies between, and the
/// weight of the second, of 256.
fn stops(from: u32, to: u32) -> Vec<[u32; 3]> {
    let scale = f64::from(from) / f64::from(to);
    let stop = |i: u32| {
        let at = ((f64::from(i) + 0.5) * scale - 0.5).clamp(0.0, f64::from(from - 1));
        let first = at as u32;
        [first, (first + 1).min(from - 1), ((at - f64::from(first)) * 256.0) as u32]
    };
    (0..to).map(stop).collect()
}

/// Mixes `b` with a weight of `parts` of 256 into `a`, two channels at a time.
#[inline]
const fn mix(a: u32, b: u32, parts: u32) -> u32 {
    const OUTER: u32 = 0x00ff_00ff;
    const INNER: u32 = 0x0000_ff00;
    let outer = ((a & OUTER) * (256 - parts) + (b & OUTER) * parts + 0x0080_0080) >> 8;
    let inner = ((a & INNER) >> 8) * (256 - parts) + ((b & INNER) >> 8) * parts + 0x80;
    (outer & OUTER) | (inner & INNER)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixes_by_hand() {
        let [black, white] = [0, pack([255; 3])];
        assert_eq!(mix(black, white, 0), black);
        assert_eq!(mix(white, white, 77), white);
        assert_eq!(mix(black, white, 128), pack([128; 3]));
        assert_eq!(mix(pack([200, 0, 40]), pack([100, 80, 0]), 64), pack([175, 20, 30]));
    }

    #[test]
    fn two_pixels_become_four() {
        let small = Picture { width: 2, height: 1, pixels: vec![0, pack([200; 3])] };
        let mut large = Picture::new(4, 2);
        small.enlarge(&mut large);
        let row = [0, 50, 150, 200].map(|v| pack([v; 3]));
        assert_eq!(large.pixels, [row, row].concat());
        let mut same = Picture::new(2, 1);
        small.enlarge(&mut same);
        assert_eq!(same, small);
        Picture::new(0, 3).enlarge(&mut same);
        small.enlarge(&mut Picture::new(0, 3));
    }

    #[test]
    fn tiles_go_where_they_belong() {
        let mut picture = Picture::new(3, 2);
        picture.put(Tile { x: 1, y: 1, width: 2, height: 1 }, &[pack([1, 2, 3]), 7]);
        assert_eq!(picture.pixels, [0, 0, 0, 0, 0x0001_0203, 7]);
        assert_eq!(picture.rgb()[12..], [1, 2, 3, 0, 0, 7]);
    }

    #[test]
    fn psnr_by_hand() {
        let black = Picture::new(2, 2);
        let mut other = black.clone();
        assert_eq!(black.psnr(&other), None);
        // One channel of twelve off by 255: 10 log10(12).
        other.pixels[3] = pack([0, 255, 0]);
        assert!((black.psnr(&other).unwrap() - 10.792).abs() < 1e-3);
        assert_eq!(black.psnr(&Picture::new(2, 1)), None);
    }
}
