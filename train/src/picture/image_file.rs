//! Pictures in files: PNG and JPEG are written, whatever `image` knows is read.

use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError};

use crate::output::{OutputError, write_atomic};

/// Default units per step of a depth file: a thousandth, as programs that read
/// millimetres expect.
pub const DEPTH_UNITS_PER_STEP: f32 = 1e-3;

/// Quality of JPEG files: differences are hardly seen.
const JPEG_QUALITY: u8 = 92;

/// Reads a picture; its first bytes say in which format. No caller compiles the decoders anew, as
/// it does with `image::open`.
///
/// # Errors
/// Those of reading and decoding.
pub fn open(path: impl AsRef<Path>) -> Result<DynamicImage, ImageError> {
    let bytes = std::fs::read(path).map_err(ImageError::IoError)?;
    image::load_from_memory(&bytes)
}

/// Writes 8-bit RGB, `width * height * 3` values from the top left: as JPEG where the name ends
/// with `.jpg` or `.jpeg`, else as PNG.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `rgb` has another length.
pub fn write_rgb(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), OutputError> {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    if extension.is_none_or(|extension| extension != "jpg" && extension != "jpeg") {
        return write(path, width, height, rgb, ExtendedColorType::Rgb8);
    }
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| refused(path, error))?;
    write_atomic(path, &jpeg)
}

/// Writes 8-bit RGBA with straight alpha, `width * height * 4` values.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `rgba` has another length.
pub fn write_rgba(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), OutputError> {
    write(path, width, height, rgba, ExtendedColorType::Rgba8)
}

/// Writes depth as 16-bit grey: `round(depth / units_per_step)`, from 1 to 65535. 0 means no
/// surface: depth that is infinite, NaN or not above 0.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `depth` does not hold `width * height` values.
pub fn write_depth(
    path: &Path,
    width: u32,
    height: u32,
    depth: &[f32],
    units_per_step: f32,
) -> Result<(), OutputError> {
    let steps: Vec<u16> = depth
        .iter()
        .map(|&depth| {
            let surface = depth.is_finite() && depth > 0.0;
            if surface { (depth / units_per_step).round().clamp(1.0, 65535.0) as u16 } else { 0 }
        })
        .collect();
    write(path, width, height, bytemuck::must_cast_slice(&steps), ExtendedColorType::L16)
}

/// Writes unit vectors as 8-bit RGB, one a pixel: `round(255 (n + 1) / 2)` of x, y and z. Black,
/// which is no unit vector, means no surface: zeros.
///
/// # Errors
/// One line that names the file.
///
/// # Panics
/// If `normals` does not hold `width * height` vectors.
pub fn write_normals(
    path: &Path,
    width: u32,
    height: u32,
    normals: &[[f32; 3]],
) -> Result<(), OutputError> {
    let byte = |v: f32| (127.5 * (v + 1.0)).round() as u8;
    let color = |normal: &[f32; 3]| match normal {
        [0.0, 0.0, 0.0] => [0; 3],
        normal => normal.map(byte),
    };
    let rgb: Vec<u8> = normals.iter().flat_map(color).collect();
    write(path, width, height, &rgb, ExtendedColorType::Rgb8)
}

/// The absolute difference of two pictures, `gain` times brighter.
#[must_use]
pub fn difference(left: &[u8], right: &[u8], gain: u8) -> Vec<u8> {
    left.iter().zip(right).map(|(l, r)| l.abs_diff(*r).saturating_mul(gain)).collect()
}

/// RGB pictures of one size next to each other: the width of all and their
/// pixels.
///
/// # Panics
/// If there is no picture, or one is not `width` wide and as high as the first.
#[must_use]
pub fn side_by_side(width: u32, pictures: &[&[u8]]) -> (u32, Vec<u8>) {
    let stride = width as usize * 3;
    let length = pictures[0].len();
    assert!(length.is_multiple_of(stride), "whole rows");
    assert!(pictures.iter().all(|picture| picture.len() == length), "pictures of one size");
    let rows = (0..length / stride).map(|y| y * stride..(y + 1) * stride);
    let rgb = rows.flat_map(|row| pictures.iter().flat_map(move |picture| &picture[row.clone()]));
    (width * pictures.len() as u32, rgb.copied().collect())
}

/// 8-bit RGB as a PNG file's bytes.
///
/// # Errors
/// What the encoder reports.
///
/// # Panics
/// If `rgb` has another length than `width * height * 3`.
pub fn encode_rgb(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, ImageError> {
    encode(width, height, rgb, ExtendedColorType::Rgb8)
}

/// 8-bit RGBA with straight alpha as a PNG file's bytes.
///
/// # Errors
/// What the encoder reports.
///
/// # Panics
/// If `rgba` has another length than `width * height * 4`.
pub fn encode_rgba(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>, ImageError> {
    encode(width, height, rgba, ExtendedColorType::Rgba8)
}

fn encode(
    width: u32,
    height: u32,
    pixels: &[u8],
    color: ExtendedColorType,
) -> Result<Vec<u8>, ImageError> {
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(pixels, width, height, color)?;
    Ok(png)
}

fn write(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[u8],
    color: ExtendedColorType,
) -> Result<(), OutputError> {
    let png = encode(width, height, pixels, color).map_err(|error| refused(path, error))?;
    write_atomic(path, &png)
}

fn refused(path: &Path, error: ImageError) -> OutputError {
    OutputError::Refused { file: path.to_owned(), source: std::io::Error::other(error) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb: Vec<u8> = (0..18).collect();
        write_rgb(&path, 3, 2, &rgb).unwrap();
        assert_eq!(open(&path).unwrap().as_rgb8().unwrap().as_raw(), &rgb);
        let rgba: Vec<u8> = (0..24).collect();
        write_rgba(&path, 3, 2, &rgba).unwrap();
        assert_eq!(open(&path).unwrap().as_rgba8().unwrap().as_raw(), &rgba);
    }

    #[test]
    fn depth_in_steps() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let depth = [2.5, 1e-9, 1e9, f32::INFINITY, f32::NAN, 0.0];
        write_depth(&path, 3, 2, &depth, DEPTH_UNITS_PER_STEP).unwrap();
        let image = open(&path).unwrap();
        assert_eq!(image.as_luma16().unwrap().as_raw(), &[2500, 1, 65535, 0, 0, 0]);
    }

    #[test]
    fn normals_as_colours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let normals = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.28, -0.96, 0.0], [0.0; 3]];
        write_normals(&path, 2, 2, &normals).unwrap();
        let image = open(&path).unwrap();
        let expected = [128, 128, 255, 0, 128, 128, 163, 5, 128, 0, 0, 0];
        assert_eq!(image.as_rgb8().unwrap().as_raw(), &expected);
    }

    #[test]
    fn the_file_is_named() {
        let error = write_rgb(Path::new("/nowhere/a.png"), 1, 1, &[0; 3]).unwrap_err();
        assert!(error.to_string().starts_with("/nowhere/a.png: "), "{error}");
    }

    #[test]
    fn pictures_next_to_each_other() {
        let left = [1, 1, 1, 2, 2, 2];
        let right = [3, 3, 3, 42, 42, 42];
        let apart = difference(&left, &right, 10);
        assert_eq!(apart, [20, 20, 20, 255, 255, 255]);
        let (width, rgb) = side_by_side(1, &[&left, &right, &apart]);
        assert_eq!(width, 3);
        assert_eq!(rgb, [1, 1, 1, 3, 3, 3, 20, 20, 20, 2, 2, 2, 42, 42, 42, 255, 255, 255]);
    }
}
