//! Smaller images and masks: averages over boxes.

use super::Image;
use crate::dataset::DatasetError;

impl Image {
    /// The average of `factor` × `factor` pixels for each pixel, taken on
    /// premultiplied values, so that invisible colours do not bleed. Where the
    /// size is no multiple, boxes are slightly larger and share pixels.
    pub(in crate::dataset) fn downscaled(self, factor: u32) -> Result<Self, DatasetError> {
        let [width, height] = self.size;
        let largest = width.min(height);
        if factor == 0 || factor > largest {
            return Err(DatasetError::DownscaleFactor { factor, largest, size: self.size });
        }
        if factor == 1 {
            return Ok(self);
        }
        let size = [width / factor, height / factor];
        let columns: Vec<_> = (0..size[0]).map(|x| shares(x, width, size[0])).collect();
        let mut rgba = Vec::with_capacity(size[0] as usize * size[1] as usize * 4);
        for y in 0..size[1] {
            let rows = shares(y, height, size[1]);
            for columns in &columns {
                rgba.extend(self.average(columns, &rows, u64::from(width) * u64::from(height)));
            }
        }
        Ok(Self { size, rgba })
    }

    /// The weighted average of some columns and rows; weights sum to `total`.
    fn average(&self, columns: &[(u32, u64)], rows: &[(u32, u64)], total: u64) -> [u8; 4] {
        let (mut color, mut alpha) = ([0u64; 3], 0u64);
        for &(y, row) in rows {
            for &(x, column) in columns {
                let at = (y as usize * self.size[0] as usize + x as usize) * 4;
                let pixel = &self.rgba[at..at + 4];
                let share = row * column * u64::from(pixel[3]);
                alpha += share;
                for (sum, &value) in color.iter_mut().zip(pixel) {
                    *sum += share * u64::from(value);
                }
            }
        }
        let rounded = |sum: u64, of: u64| (sum + of / 2).checked_div(of).unwrap_or(0) as u8;
        let [r, g, b] = color.map(|sum| rounded(sum, alpha));
        [r, g, b, rounded(alpha, total)]
    }
}

/// A mask made as small as its image: a pixel counts if all under it do.
pub(in crate::dataset) fn downscaled_mask(
    [width, height]: [u32; 2],
    mask: &[u8],
    size: [u32; 2],
) -> Vec<u8> {
    let columns: Vec<_> = (0..size[0]).map(|x| shares(x, width, size[0])).collect();
    let mut small = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for y in 0..size[1] {
        let rows = shares(y, height, size[1]);
        let under = |columns: &Vec<(u32, u64)>| {
            let at = |x: u32, y: u32| mask[y as usize * width as usize + x as usize];
            let pixels = rows.iter().flat_map(|(y, _)| columns.iter().map(move |(x, _)| (*x, *y)));
            pixels.map(|(x, y)| at(x, y)).min().unwrap_or(0)
        };
        small.extend(columns.iter().map(under));
    }
    small
}

/// The old pixels under new pixel `new` of a side that goes from `from` to
/// `to` pixels, each with its share; the shares sum to `from`.
fn shares(new: u32, from: u32, to: u32) -> Vec<(u32, u64)> {
    let (from, to, new) = (u64::from(from), u64::from(to), u64::from(new));
    let (begin, end) = (new * from, (new + 1) * from);
    (begin / to..end.div_ceil(to))
        .map(|old| (old as u32, end.min((old + 1) * to) - begin.max(old * to)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_a_side_exactly() {
        assert_eq!(shares(1, 4, 2), [(2, 2), (3, 2)]);
        // 5 pixels become 2: the middle one is shared.
        assert_eq!(shares(0, 5, 2), [(0, 2), (1, 2), (2, 1)]);
        assert_eq!(shares(1, 5, 2), [(2, 1), (3, 2), (4, 2)]);
    }

    #[test]
    fn downscaling_averages_premultiplied() {
        // Opaque red and invisible green.
        let row = [[200, 0, 0, 255], [0, 255, 0, 0]].concat();
        let image = Image { size: [2, 2], rgba: [row.clone(), row].concat() };
        let small = image.clone().downscaled(2).unwrap();
        assert_eq!(small, Image { size: [1, 1], rgba: vec![200, 0, 0, 128] });
        assert_eq!(image.clone().downscaled(1).unwrap(), image);
        for factor in [0, 3] {
            let error = image.clone().downscaled(factor).unwrap_err().to_string();
            assert!(error.ends_with("expected 1 to 2 for images of 2x2"), "{error}");
        }
    }

    #[test]
    fn a_small_pixel_counts_where_all_under_it_do() {
        let mask = [255, 255, 0, 255, 255, 255, 255, 255];
        assert_eq!(downscaled_mask([4, 2], &mask, [2, 1]), [255, 0]);
        assert_eq!(downscaled_mask([4, 2], &mask, [4, 2]), mask);
        // 5 pixels become 2: the middle one is shared.
        assert_eq!(downscaled_mask([5, 2], &[9, 9, 0, 9, 9, 9, 9, 9, 9, 9], [2, 1]), [0, 0]);
    }

    #[test]
    fn a_flat_image_stays_flat() {
        let image = Image { size: [7, 5], rgba: [9, 80, 255, 77].repeat(35) };
        let small = image.downscaled(2).unwrap();
        assert_eq!(small, Image { size: [3, 2], rgba: [9, 80, 255, 77].repeat(6) });
    }
}
