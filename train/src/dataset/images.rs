//! Finds and decodes image files, and makes them smaller.

use std::io::Cursor;
use std::path::Path;

use image::metadata::Orientation;
use image::{ImageFormat, ImageReader};

use super::DatasetError;

/// A decoded image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Image {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Straight RGBA, row after row from the top.
    pub(super) rgba: Vec<u8>,
}

/// The path relative to `folder` at which the image lies: as it is written, or
/// with an extension added.
pub(super) fn find(folder: &Path, path: &str) -> Option<String> {
    ["", ".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"]
        .iter()
        .map(|extension| format!("{path}{extension}"))
        .find(|name| folder.join(name).is_file())
}

/// What images' names end with, in small letters.
pub(super) const EXTENSIONS: [&str; 3] = ["png", "jpg", "jpeg"];

/// The names of the files in a folder that end like that, sorted; hidden ones left out.
pub(super) fn names(folder: &Path, extensions: &[&str]) -> Result<Vec<String>, DatasetError> {
    let unlistable = |source| DatasetError::Unlistable { folder: folder.to_owned(), source };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unlistable)? {
        let name = entry.map_err(unlistable)?.file_name().to_string_lossy().into_owned();
        let extension = name.rsplit_once('.').map(|(_, extension)| extension.to_lowercase());
        let fits = extension.is_some_and(|extension| extensions.contains(&extension.as_str()));
        if fits && !name.starts_with('.') {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// Decodes a PNG or JPEG file, whatever its name ends with, to 8 bits per
/// channel; alpha is 255 where the file has none.
pub(super) fn decode(path: &Path) -> Result<Image, DatasetError> {
    decode_bytes(path)
        .map_err(|problem| DatasetError::UnreadableImage { image: path.to_owned(), problem })
}

/// Width and height by a file's header; reads no more than that.
pub(super) fn size(path: &Path) -> Option<[u32; 2]> {
    let reader = ImageReader::open(path).ok()?.with_guessed_format().ok()?;
    reader.into_dimensions().ok().map(|(width, height)| [width, height])
}

/// What a file says of its image before any pixel is decoded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Whether there is an alpha channel.
    pub(super) alpha: bool,
    /// Whether EXIF says that the image is to be shown turned or mirrored.
    pub(super) is_turned: bool,
    /// Equal where files are.
    pub(super) content: u64,
}

/// The header of a file that is whole; decodes no pixel.
pub(super) fn header(path: &Path) -> Option<Header> {
    use image::ImageDecoder as _;
    let bytes = std::fs::read(path).ok()?;
    let format = image::guess_format(&bytes).ok()?;
    if is_cut_off(format, &bytes) {
        return None;
    }
    let content = super::hash_of(&bytes);
    let mut decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Some(Header {
        size: [width, height],
        alpha: decoder.color_type().has_alpha(),
        is_turned: orientation != Orientation::NoTransforms,
        content,
    })
}

/// Whether the end of a PNG or JPEG file is missing.
fn is_cut_off(format: ImageFormat, bytes: &[u8]) -> bool {
    match format {
        ImageFormat::Jpeg => !has_end_marker(bytes),
        ImageFormat::Png => !has_end_chunk(bytes),
        _ => false,
    }
}

/// Whether a PNG's chunks, each a length, a name, so many bytes and a checksum, lead to the
/// one that ends it.
fn has_end_chunk(png: &[u8]) -> bool {
    let mut rest = png.get(8..).unwrap_or_default();
    while let Some(([a, b, c, d, name @ ..], _)) = rest.split_first_chunk::<8>() {
        if name == b"IEND" {
            return true;
        }
        let len = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        rest = rest.get(len.saturating_add(12)..).unwrap_or_default();
    }
    false
}

fn decode_bytes(path: &Path) -> Result<Image, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    if bytes.is_empty() {
        return Err("the file has 0 bytes".to_owned());
    }
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        return Err("an EXR file of linear colours".to_owned());
    }
    let format = image::guess_format(&bytes).ok();
    let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
        return Err("neither PNG nor JPEG".to_owned());
    };
    if is_cut_off(format, &bytes) {
        return Err("the file is cut off: its end is missing".to_owned());
    }
    let image = ImageReader::with_format(Cursor::new(bytes), format)
        .decode()
        .map_err(|error| error.to_string())?;
    let size = [image.width(), image.height()];
    if size.contains(&0) {
        return Err(format!("{}x{} pixels", size[0], size[1]));
    }
    Ok(Image { size, rgba: image.into_rgba8().into_raw() })
}

/// Whether an end-of-image marker follows a JPEG's last scan. The decoder
/// fills what is missing with grey, without a word.
fn has_end_marker(jpeg: &[u8]) -> bool {
    let last = |marker: [u8; 2]| jpeg.windows(2).rposition(|pair| pair == marker);
    matches!((last([0xff, 0xda]), last([0xff, 0xd9])), (Some(scan), Some(end)) if end > scan)
}

impl Image {
    /// The average of `factor` × `factor` pixels for each pixel, taken on
    /// premultiplied values, so that invisible colours do not bleed. Where the
    /// size is no multiple, boxes are slightly larger and share pixels.
    pub(super) fn downscaled(self, factor: u32) -> Result<Self, DatasetError> {
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
pub(super) fn downscaled_mask([width, height]: [u32; 2], mask: &[u8], size: [u32; 2]) -> Vec<u8> {
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
