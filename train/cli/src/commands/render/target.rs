//! What is written: a picture, pictures in a folder, or a video.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use pocketnerf_train::output;

use crate::commands::{Failure, make_folder};

/// What the name of an output asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Target {
    /// One picture.
    Picture(PathBuf),
    /// Pictures, numbered from 000.png.
    Folder(PathBuf),
    /// A video.
    Video(PathBuf, Kind),
}

/// A kind of video.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Mp4,
    WebM,
    Gif,
}

impl Kind {
    /// By the file's extension.
    pub(super) fn of(path: &Path) -> Option<Self> {
        match extension(path)?.as_str() {
            "mp4" => Some(Self::Mp4),
            "webm" => Some(Self::WebM),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }
}

impl Target {
    /// For so many pictures.
    ///
    /// # Errors
    /// The name is that of another kind of output, or it cannot be written.
    pub(super) fn new(path: &Path, pictures: usize) -> Result<Self, Failure> {
        if let Some(kind) = Kind::of(path) {
            output::check_output(path)?;
            return Ok(Self::Video(path.to_owned(), kind));
        }
        let is_picture = matches!(extension(path).as_deref(), Some("png" | "jpg" | "jpeg"));
        if pictures != 1 {
            if is_picture {
                let name = path.display();
                return Err(format!(
                    "{name}: {pictures} pictures, expected the name of a folder or of a video \
                     (.mp4, .webm, .gif)"
                )
                .into());
            }
            return Ok(Self::Folder(make_folder(path)?));
        }
        if let (false, Some(found)) = (is_picture, extension(path)) {
            let name = path.display();
            return Err(format!(
                "{name}: .{found}, expected .png or .jpg for a picture, .mp4, .webm or .gif for a \
                 video"
            )
            .into());
        }
        output::check_output(path)?;
        Ok(Self::Picture(path.to_owned()))
    }

    /// The file of a picture.
    pub(super) fn picture(&self, i: usize) -> Option<PathBuf> {
        match self {
            Self::Picture(path) => Some(path.clone()),
            Self::Folder(folder) => Some(folder.join(format!("{i:03}.png"))),
            Self::Video(..) => None,
        }
    }
}

fn extension(path: &Path) -> Option<String> {
    path.extension().and_then(OsStr::to_str).map(str::to_lowercase)
}
