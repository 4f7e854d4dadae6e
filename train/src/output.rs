//! Files that are whole or not there: written beside their place and renamed.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

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
    /// The system refused.
    #[error("{}: cannot be written: {source}; check permissions and free space", one_line(.file))]
    Refused {
        /// The file to write.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Whether a file can be written at `path`: ask before long work, not after.
/// An existing file may be replaced and is left as it is.
///
/// # Errors
/// One line that says what is in the way.
pub fn check_output(path: &Path) -> Result<(), OutputError> {
    temporary(path).map(drop)
}

/// Writes `bytes` to a temporary file in the same folder and renames it, so
/// that `path` never holds half a file.
///
/// # Errors
/// As [`check_output`], or when the disk is full; `path` is then as it was.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let refused = |source| OutputError::Refused { file: path.to_owned(), source };
    let mut file = temporary(path)?;
    file.write_all(bytes).map_err(refused)?;
    file.persist(path).map_err(|error| refused(error.error))?;
    Ok(())
}

/// The folder a file lies in.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// An open temporary file in the folder of `path`; it vanishes when dropped.
fn temporary(path: &Path) -> Result<tempfile::NamedTempFile, OutputError> {
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
        Ok(kind) if kind.is_dir() => {}
        Ok(_) => return Err(OutputError::FolderIsAFile { file, folder: folder.to_owned() }),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            return Err(OutputError::FolderIsAFile { file, folder: first_file(folder) });
        }
        Err(_) => return Err(OutputError::NoFolder { file, folder: folder.to_owned() }),
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pocketnerf-").suffix(".tmp");
    // As any newly created file; the system takes the user's mask off.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|source| OutputError::Refused { file, source })
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
