//! A picture in tiles.

use crate::render::Tile;

/// The tiles of a picture, row after row: so many pixels each that their passes fill
/// batches, so few that their part of a model's tables stays in the cache, and at least 48 of them
/// where that is possible, so that threads end together.
///
/// Pictures in less than the finest quality depend on their tiles a little, because
/// pixels are interpolated within one. Whoever cuts a picture like this gets the same
/// bytes as every other host.
///
/// ```
/// use pocketnerf_core::Tile;
/// use pocketnerf_core::render::Tiles;
///
/// let tiles = Tiles::new(800, 800);
/// assert_eq!((tiles.size(), tiles.len()), ([128, 64], 7 * 13));
/// // The last column and row are narrower.
/// assert_eq!(tiles.get(90), Some(Tile { x: 768, y: 768, width: 32, height: 32 }));
/// assert_eq!(tiles.map(|tile| tile.pixels()).sum::<usize>(), 800 * 800);
/// ```
#[derive(Clone, Debug)]
pub struct Tiles {
    picture: [u32; 2],
    tile: [u32; 2],
    next: u32,
}

impl Tiles {
    /// Width and height that no tile exceeds.
    pub const LARGEST: [u32; 2] = [128, 64];
    /// Pixels that no tile exceeds.
    pub const MOST_PIXELS: usize = (Self::LARGEST[0] * Self::LARGEST[1]) as usize;
    /// Tiles of a picture at least.
    const LEAST: u32 = 48;
    /// Widths of tiles are multiples of this, the spacing of the coarsest picture.
    const WIDTH_STEP: u32 = 16;
    /// Rows of a tile at least.
    const LEAST_ROWS: u32 = 16;

    /// Rays along a side of a pixel at most: more than one pixel's do not fit into a tile.
    pub const MOST_RAYS: u32 = Self::LARGEST[1];

    /// Those of a picture of this width and height: as wide as the largest or a little
    /// narrower, so that none is left much narrower than the others.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self::supersampled(width, height, 1)
    }

    /// The same for `n` × `n` rays a pixel, at least 1 and at most [`MOST_RAYS`](Self::MOST_RAYS)
    /// along a side: tiles of which the [finer](Tile::finer) ones are no larger than others.
    /// Render [`tile.finer(n)`](Tile::finer) as [`camera.finer(n)`](crate::Camera::finer) sees
    /// it, then [`average_tile`](crate::render::average_tile).
    ///
    /// ```
    /// use pocketnerf_core::render::Tiles;
    ///
    /// let tiles = Tiles::supersampled(100, 100, 8);
    /// assert_eq!(tiles.size(), [16, 8]);
    /// assert!(tiles.map(|tile| tile.finer(8).pixels()).max() <= Some(Tiles::MOST_PIXELS));
    /// ```
    #[must_use]
    pub fn supersampled(width: u32, height: u32, n: u32) -> Self {
        let n = n.clamp(1, Self::MOST_RAYS);
        let [most, mut rows] = Self::LARGEST.map(|side| side / n);
        let [step, least] = [Self::WIDTH_STEP, Self::LEAST_ROWS].map(|side| (side / n).max(1));
        let columns = width.div_ceil(most).max(1);
        while rows > least && columns.saturating_mul(height.div_ceil(rows)) < Self::LEAST {
            rows /= 2;
        }
        let wide = width.div_ceil(columns).next_multiple_of(step);
        Self { picture: [width, height], tile: [wide.clamp(step, most), rows], next: 0 }
    }

    /// Width and height of all tiles but those at the right and at the bottom.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.tile
    }

    /// The tile of this number.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<Tile> {
        let ([width, height], [w, h]) = (self.picture, self.tile);
        let [columns, rows] = self.counts();
        if columns == 0 || number / columns >= rows {
            return None;
        }
        let (x, y) = (number % columns * w, number / columns * h);
        Some(Tile { x, y, width: w.min(width - x), height: h.min(height - y) })
    }

    /// Columns and rows of tiles.
    const fn counts(&self) -> [u32; 2] {
        let [width, height] = self.picture;
        [width.div_ceil(self.tile[0]), height.div_ceil(self.tile[1])]
    }
}

impl Iterator for Tiles {
    type Item = Tile;

    fn next(&mut self) -> Option<Tile> {
        let tile = self.get(self.next)?;
        self.next += 1;
        Some(tile)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let [columns, rows] = self.counts();
        let left = columns.saturating_mul(rows).saturating_sub(self.next) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Tiles {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once() {
        for [width, height] in [[1, 1], [17, 3], [400, 300], [1000, 33], [129, 1999]] {
            let mut seen = [0u8; 1 << 18];
            let tiles = Tiles::new(width, height);
            assert_eq!(tiles.len(), tiles.clone().count());
            for tile in tiles {
                assert!(tile.width <= 128 && tile.height <= 64);
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(seen[..(width * height) as usize].iter().all(|n| *n == 1));
        }
    }

    #[test]
    fn tiles_of_many_rays_are_no_larger() {
        for n in [1, 2, 3, 5, 8, 17, 33, 64, 65, 0, u32::MAX] {
            for [width, height] in [[1, 1], [17, 3], [100, 75], [400, 300]] {
                let rays = n.clamp(1, Tiles::MOST_RAYS);
                let mut pixels = 0;
                for tile in Tiles::supersampled(width, height, n) {
                    let fine = tile.finer(rays);
                    assert!(fine.width <= 128 && fine.height <= 64, "{n}: {tile:?}");
                    pixels += tile.pixels();
                }
                assert_eq!(pixels, (width * height) as usize, "{n}: {width}x{height}");
            }
        }
        // Those of the picture that is rendered, where n divides them.
        assert_eq!(Tiles::supersampled(200, 200, 4).size(), [32, 16]);
        assert_eq!(Tiles::new(800, 800).size(), [128, 64]);
    }

    #[test]
    fn pictures_without_pixels_have_no_tiles() {
        for [width, height] in [[0, 5], [5, 0], [0, 0]] {
            assert_eq!(Tiles::new(width, height).count(), 0);
        }
        assert_eq!(Tiles::new(u32::MAX, u32::MAX).len(), u32::MAX as usize);
        assert_eq!(Tiles::new(u32::MAX, 1).get((1 << 25) - 1).map(|tile| tile.width), Some(127));
    }
}
