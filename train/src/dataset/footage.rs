//! Photographs and videos that have no cameras yet.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{DatasetError, images};

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Footage {
    /// A video, by its ending.
    Video,
    /// An archive, by its ending, or by a zip's first bytes.
    Archive,
    /// Anything else.
    Other,
}

impl Footage {
    /// What the file at `path` is.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        const VIDEOS: [&str; 8] = ["mp4", "mov", "m4v", "mkv", "webm", "avi", "mpg", "mts"];
        const ARCHIVES: [&str; 7] = ["zip", "r3d", "tar", "gz", "tgz", "7z", "rar"];
        let mut first = [0; 4];
        let is_read = File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending {
            _ if is_read && first == *b"PK\x03\x04" => Self::Archive,
            Some(ending) if ARCHIVES.contains(&ending.as_str()) => Self::Archive,
            Some(ending) if VIDEOS.contains(&ending.as_str()) => Self::Video,
            _ => Self::Other,
        }
    }
}

/// The names of the photographs in a folder (those that can be read, not those in folders inside), sorted.
///
/// # Errors
/// The folder cannot be listed.
pub fn photographs(folder: &Path) -> Result<Vec<String>, DatasetError> {
    images::names(folder, &images::EXTENSIONS)
}

/// Whether images have one width and height, by their headers.
#[must_use]
pub fn are_of_one_size(folder: &Path, names: &[String]) -> bool {
    let mut sizes = names.iter().map(|name| images::size(&folder.join(name)));
    let first = sizes.next().flatten();
    first.is_some() && sizes.all(|size| size == first)
}

/// A refusal that names the next step, where a folder holds photographs, or a file is footage.
pub(super) fn next_step(path: &Path) -> Option<DatasetError> {
    if path.is_file() {
        return match Footage::of(path) {
            Footage::Video => Some(DatasetError::Video(path.to_owned())),
            Footage::Archive => Some(DatasetError::Archive(path.to_owned())),
            Footage::Other => None,
        };
    }
    let places = [path.to_owned(), path.join("images")];
    places.into_iter().find_map(|folder| {
        // Phones' photographs too, which have to be converted.
        let endings = images::EXTENSIONS.into_iter().chain(["heic", "heif", "avif"]);
        let photographs = images::names(&folder, &endings.collect::<Vec<_>>()).ok()?.len();
        (photographs > 0).then_some(DatasetError::NoPoses(folder, photographs))
    })
}
