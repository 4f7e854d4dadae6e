//! Pictures as PNG files.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{ColorType, ImageFormat};

use crate::paint::picture::Picture;

/// Writes a picture as PNG, completely or not at all.
///
/// # Errors
/// One line: the file, and the system's error.
pub fn write(path: &Path, picture: &Picture) -> Result<(), String> {
    let failed = |e: &dyn std::fmt::Display| {
        format!("{}: cannot be written: {e}; give another place", path.display())
    };
    let mut png = Cursor::new(Vec::new());
    let (width, height) = (picture.width, picture.height);
    let rgb = picture.rgb();
    image::write_buffer_with_format(
        &mut png,
        &rgb,
        width,
        height,
        ColorType::Rgb8,
        ImageFormat::Png,
    )
    .map_err(|e| failed(&e))?;
    pocketnerf_formats::write_atomically(path, png.get_ref()).map_err(|e| failed(&e))
}

/// The first unused name in `folder`: `stem-001.png` and so on.
#[must_use]
pub fn free_name(folder: &Path, stem: &str) -> PathBuf {
    let name = |n: u32| folder.join(format!("{stem}-{n:03}.png"));
    (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
}
