//! Finds and decodes image files, and makes them smaller.

mod format;
mod linear;
mod smaller;

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder as _, ImageReader, RgbaImage};

use super::DatasetError;
pub(super) use smaller::downscaled_mask;

/// A decoded image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Image {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Straight RGBA, row after row from the top.
    pub(super) rgba: Vec<u8>,
}

/// An image as its file has it.
#[derive(Clone, Debug)]
pub(super) struct Stored {
    pub(super) image: Image,
    /// How EXIF says that it is to be turned.
    pub(super) orientation: Orientation,
    /// Whether its colours were linear.
    pub(super) was_linear: bool,
}

/// Bytes of an image's decoded pixels at most.
const LARGEST: u64 = 512 << 20;

/// The path relative to `folder` at which the image lies: as it is written, or
/// with an extension added.
pub(super) fn find(folder: &Path, path: &str) -> Option<String> {
    let endings = EXTENSIONS.iter().map(|ending| format!(".{ending}"));
    let endings: Vec<String> = std::iter::once(String::new()).chain(endings).collect();
    let capitals = endings[1..].iter().map(|ending| ending.to_uppercase());
    endings
        .iter()
        .cloned()
        .chain(capitals)
        .map(|ending| format!("{path}{ending}"))
        .find(|name| folder.join(name).is_file())
}

/// What images' names end with, in small letters.
pub(super) const EXTENSIONS: [&str; 7] = ["png", "jpg", "jpeg", "webp", "tif", "tiff", "exr"];

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

/// Decodes an image file, whatever its name ends with, to 8 bits per channel; alpha is 255
/// where the file has none. EXIF turns nothing.
pub(super) fn decode(path: &Path) -> Result<Image, DatasetError> {
    read(path).map(|stored| stored.image)
}

/// The same, with what else the file says.
pub(super) fn read(path: &Path) -> Result<Stored, DatasetError> {
    decode_bytes(path)
        .map_err(|problem| DatasetError::UnreadableImage { image: path.to_owned(), problem })
}

/// What images are read from.
trait Source: BufRead + Seek {}

impl<T: BufRead + Seek> Source for T {}

/// One type for files and memory: decoders are generic, and large.
fn reader<'a>(source: Box<dyn Source + 'a>) -> ImageReader<Box<dyn Source + 'a>> {
    ImageReader::new(source)
}

/// Width and height by a file's header; reads no more than that.
pub(super) fn size(path: &Path) -> Option<[u32; 2]> {
    let file = BufReader::new(File::open(path).ok()?);
    let reader = reader(Box::new(file)).with_guessed_format().ok()?;
    reader.into_dimensions().ok().map(|(width, height)| [width, height])
}

/// What a file says of its image before any pixel is decoded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Whether there is an alpha channel.
    pub(super) alpha: bool,
    /// How EXIF says that the image is to be turned.
    pub(super) orientation: Orientation,
    /// Equal where files are.
    pub(super) content: u64,
}

/// The header of a file that is whole; decodes no pixel.
pub(super) fn header(path: &Path) -> Option<Header> {
    let bytes = std::fs::read(path).ok()?;
    let format = format::of(&bytes).ok()?;
    let content = super::hash_of(&bytes);
    let mut reader = reader(Box::new(Cursor::new(bytes)));
    reader.set_format(format);
    let mut decoder = reader.into_decoder().ok()?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let (size, alpha) = (decoder.dimensions().into(), decoder.color_type().has_alpha());
    Some(Header { size, alpha, orientation, content })
}

fn decode_bytes(path: &Path) -> Result<Stored, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let format = format::of(&bytes)?;
    let mut reader = reader(Box::new(Cursor::new(&bytes)));
    reader.set_format(format);
    let mut decoder = reader.into_decoder().map_err(short)?;
    let size: [u32; 2] = decoder.dimensions().into();
    if size.contains(&0) {
        return Err(format!("{}x{} pixels", size[0], size[1]));
    }
    if decoder.total_bytes() > LARGEST {
        return Err(format!("{}x{} pixels are too many", size[0], size[1]));
    }
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let image = DynamicImage::from_decoder(decoder).map_err(short)?;
    let (rgba, was_linear) = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            (linear::to_srgb(&image.into_rgba32f()), true)
        }
        image => (image.into_rgba8().into_raw(), false),
    };
    Ok(Stored { image: Image { size, rgba }, orientation, was_linear })
}

/// The beginning of a decoder's reason: some list all that they found.
fn short(error: image::ImageError) -> String {
    const SHOWN: usize = 160;
    let text = error.to_string();
    let mut begin: String = text.chars().take(SHOWN).collect();
    if begin.len() < text.len() {
        begin.push('…');
    }
    begin
}

impl Image {
    /// Turned as EXIF says.
    pub(super) fn turned(self, orientation: Orientation) -> Self {
        let Self { size: [width, height], rgba } = self;
        // The pixels are as many as the size says.
        let image = RgbaImage::from_raw(width, height, rgba).unwrap_or_default();
        let mut image = DynamicImage::from(image);
        image.apply_orientation(orientation);
        Self { size: [image.width(), image.height()], rgba: image.into_rgba8().into_raw() }
    }
}

/// Whether a picture so turned is as wide as it was high.
pub(super) fn swaps(orientation: Orientation) -> bool {
    orientation.to_exif() >= 5
}
