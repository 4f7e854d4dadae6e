//! What is given: a folder of photographs, or a video.

use std::path::{Path, PathBuf};

use pocketnerf_train::dataset::{DatasetError, Footage};

use crate::commands::Failure;

/// What a dataset is made from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The names of the photographs in a folder, sorted.
    Photos {
        folder: PathBuf,
        names: Vec<String>,
    },
    Video(PathBuf),
}

impl Source {
    /// Looks at what lies at a path.
    pub(super) fn at(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        if path.is_dir() {
            let names = pocketnerf_train::dataset::photographs(path)?;
            return match &names[..] {
                [] => Err(format!(
                    "{shown}: no PNG or JPEG files in this folder; give the folder that holds the \
                     photographs (others, such as HEIC or raw files, need to be converted)"
                )
                .into()),
                [one] => Err(format!(
                    "{shown}: {one} is the only photograph, expected 20 or more that overlap"
                )
                .into()),
                _ => Ok(Self::Photos { folder: path.to_owned(), names }),
            };
        }
        if !path.is_file() {
            return Err(DatasetError::Missing(path.to_owned()).into());
        }
        match Footage::of(path) {
            Footage::Video => Ok(Self::Video(path.to_owned())),
            Footage::Archive => Err(DatasetError::Archive(path.to_owned()).into()),
            Footage::Other => Err(format!(
                "{shown}: neither a folder of photographs nor a video (mp4, mov, mkv, webm, avi, \
                 m4v); give one of these"
            )
            .into()),
        }
    }

    /// What identifies it, for going on later.
    pub(super) fn identity(&self) -> String {
        let whole = |path: &Path| {
            path.canonicalize().unwrap_or_else(|_| path.to_owned()).display().to_string()
        };
        match self {
            Self::Photos { folder, names } => {
                let size = |name: &String| folder.join(name).metadata().map_or(0, |m| m.len());
                let bytes: u64 = names.iter().map(size).sum();
                format!("{}: {} photographs, {bytes} bytes", whole(folder), names.len())
            }
            Self::Video(file) => {
                let bytes = file.metadata().map_or(0, |m| m.len());
                format!("{}: {bytes} bytes", whole(file))
            }
        }
    }
}
