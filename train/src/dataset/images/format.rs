//! Which format a file of an image has, and whether its end is there.

use image::ImageFormat;

/// What to do about images that cannot be read.
const CONVERT: &str = "convert it to PNG";

/// The format of a whole file; else what is wrong with it.
pub(super) fn of(bytes: &[u8]) -> Result<ImageFormat, String> {
    use ImageFormat::{Jpeg, OpenExr, Png, Tiff, WebP};
    if bytes.is_empty() {
        return Err("the file has 0 bytes".to_owned());
    }
    if let Some(name) = other(bytes) {
        return Err(format!("{name}: {CONVERT}"));
    }
    match image::guess_format(bytes) {
        Ok(format @ (Png | Jpeg | WebP | Tiff | OpenExr)) if is_cut_off(format, bytes) => {
            Err("the file is cut off: its end is missing".to_owned())
        }
        Ok(format @ (Png | Jpeg | WebP | Tiff | OpenExr)) => Ok(format),
        _ => Err("neither PNG nor JPEG, WebP, TIFF or EXR".to_owned()),
    }
}

/// A format that is known by name only.
fn other(bytes: &[u8]) -> Option<&'static str> {
    let brand = bytes.get(8..12).filter(|_| bytes.get(4..8) == Some(b"ftyp"));
    match brand {
        Some(b"avif" | b"avis") => return Some("an AVIF file"),
        Some(b"heic" | b"heix" | b"hevc" | b"heim" | b"heis" | b"mif1" | b"msf1") => {
            return Some("a HEIC file");
        }
        Some(b"crx ") => return Some("a camera's raw file"),
        _ => {}
    }
    let signs: [(&[u8], _); 6] = [
        (b"\xff\x0a", "a JPEG XL file"),
        (b"\0\0\0\x0cJXL ", "a JPEG XL file"),
        (b"GIF8", "a GIF file"),
        (b"BM", "a BMP file"),
        (b"#?RADIANCE", "a Radiance file"),
        (b"II*\0\x10\0\0\0CR", "a camera's raw file"),
    ];
    signs.into_iter().find(|(sign, _)| bytes.starts_with(sign)).map(|(_, name)| name)
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

/// Whether an end-of-image marker follows a JPEG's last scan. The decoder
/// fills what is missing with grey, without a word.
fn has_end_marker(jpeg: &[u8]) -> bool {
    let last = |marker: [u8; 2]| jpeg.windows(2).rposition(|pair| pair == marker);
    matches!((last([0xff, 0xda]), last([0xff, 0xd9])), (Some(scan), Some(end)) if end > scan)
}
