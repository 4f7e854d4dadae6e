//! Files that are written whole or not at all, and why one cannot be written.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use pocketnerf_formats::write_atomically;

use crate::json::one_line;

/// Why a file cannot be written. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path is a folder, or has no file name.
    #[error("{}: this is a folder, expected a file to write; add a file name", one_line(.0))]
    IsAFolder(PathBuf),
    /// Something lies there that is no file.
    #[error("{}: this is not a regular file; choose another name", one_line(.0))]
    NotAFile(PathBuf),
    /// The folder does not exist.
    #[error("{}: the folder {} does not exist; create it first", one_line(.file), one_line(.folder))]
    NoFolder {
        /// The file to write.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// What should be the folder is a file.
    #[error("{}: {} is a file, expected a folder; choose another place", one_line(.file), one_line(.folder))]
    FolderIsAFile {
        /// The file to write.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// A lens that the file's format cannot name.
    #[error(
        "{}: {image} has a {lens} lens, expected pinhole, opencv or fisheye, which alone this format \
         knows; undistort the images",
        one_line(.file)
    )]
    Lens {
        /// The file to write.
        file: PathBuf,
        /// The image's name.
        image: String,
        /// The lens's name.
        lens: &'static str,
    },
    /// The system refused.
    #[error("{}: cannot be written: {source}; check permissions and free space", one_line(.file))]
    Refused {
        /// The file to write.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Checks that a file can be written at `path`, before long work rather than after it.
/// An existing file is left as it is.
///
/// # Errors
/// One line that says what is in the way.
pub fn check_output(path: &Path) -> Result<(), OutputError> {
    check_place(path)?;
    let refused = |source| OutputError::Refused { file: path.to_owned(), source };
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let attempt = path.with_file_name(name);
    File::create_new(&attempt).map_err(refused)?;
    std::fs::remove_file(&attempt).map_err(refused)
}

/// Writes `bytes` so that `path` never holds half a file, whatever happens:
/// see [`write_atomically`].
///
/// # Errors
/// As [`check_output`], or when the disk is full; `path` is then as it was.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    check_place(path)?;
    write_atomically(path, bytes)
        .map_err(|source| OutputError::Refused { file: path.to_owned(), source })
}

/// The folder a file lies in.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Checks that `path` names a file, in a folder that exists.
fn check_place(path: &Path) -> Result<(), OutputError> {
    let file = path.to_owned();
    let ends_as_folder = path.to_string_lossy().ends_with(std::path::is_separator);
    if path.is_dir() || path.file_name().is_none() || ends_as_folder {
        return Err(OutputError::IsAFolder(file));
    }
    if path.exists() && !path.is_file() {
        return Err(OutputError::NotAFile(file));
    }
    let folder = folder_of(path);
    match std::fs::metadata(folder) {
        Ok(kind) if kind.is_dir() => Ok(()),
        Ok(_) => Err(OutputError::FolderIsAFile { file, folder: folder.to_owned() }),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            Err(OutputError::FolderIsAFile { file, folder: first_file(folder) })
        }
        Err(_) => Err(OutputError::NoFolder { file, folder: folder.to_owned() }),
    }
}

/// The part of a folder's path that is a file.
fn first_file(folder: &Path) -> PathBuf {
    folder.ancestors().find(|part| part.is_file()).unwrap_or(folder).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_the_way_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "old").unwrap();
        let message = |name: &str| check_output(&at(name)).unwrap_err().to_string();
        assert!(
            message("").ends_with("this is a folder, expected a file to write; add a file name")
        );
        assert!(message("new/").contains("this is a folder"));
        assert!(message("none/m.pnerf").contains("none does not exist; create it first"));
        assert!(message("file/m.pnerf").contains("file is a file, expected a folder"));
        assert!(message("file/deeper/m.pnerf").contains("file is a file, expected a folder"));
        assert!(check_output(Path::new("")).is_err());
        // Existing files may be replaced, and asking changes nothing.
        check_output(&at("file")).unwrap();
        check_output(&at("m.pnerf")).unwrap();
        assert_eq!(std::fs::read(at("file")).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn places_where_nothing_can_be_written() {
        assert!(matches!(
            check_output(Path::new("/proc/m.pnerf")),
            Err(OutputError::Refused { .. })
        ));
        assert!(matches!(check_output(Path::new("/dev/null")), Err(OutputError::NotAFile(_))));
    }

    #[test]
    fn a_file_is_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.pnerf");
        write_atomic(&path, b"first").unwrap();
        write_atomic(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            std::fs::write(folder.path().join("plain"), "").unwrap();
            let mode = |name: &str| {
                std::fs::metadata(folder.path().join(name)).unwrap().permissions().mode()
            };
            assert_eq!(mode("m.pnerf"), mode("plain"));
        }
    }
}
