//! A file on disk is the old one or the new one, never a part.

use std::ffi::OsString;
use std::format;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Writes `bytes` to `path`: to a temporary name in the same folder, through to
/// the disk, then renamed over whatever was there.
///
/// # Errors
/// Whatever the file system reports. A file that stood at `path` is then as it
/// was, and the temporary file is gone.
pub fn write_atomically(path: impl AsRef<Path>, bytes: &[u8]) -> io::Result<()> {
    replace(path.as_ref(), bytes, |file| file)
}

/// As [`write_atomically`]; `through` may put a writer before the file.
fn replace<W: Write>(path: &Path, bytes: &[u8], through: impl FnOnce(File) -> W) -> io::Result<()> {
    let (temporary, file) = Temporary::create(path)?;
    let mut writer = through(file.try_clone()?);
    writer.write_all(bytes)?;
    writer.flush()?;
    drop(writer);
    // Renamed before it is on the disk, a file can be empty after a power cut.
    file.sync_all()?;
    drop(file);
    temporary.rename(path)?;
    sync_folder(path);
    Ok(())
}

/// A file that is removed unless it is renamed.
struct Temporary(Option<PathBuf>);

impl Temporary {
    fn create(path: &Path) -> io::Result<(Self, File)> {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let Some(name) = path.file_name() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "a path without a file name"));
        };
        // Unique among the threads of this process and among processes.
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let mut temporary = OsString::from(name);
        temporary.push(format!(".{}-{number}.tmp", std::process::id()));
        let temporary = path.with_file_name(temporary);
        let file = File::create_new(&temporary)?;
        Ok((Self(Some(temporary)), file))
    }

    fn rename(mut self, path: &Path) -> io::Result<()> {
        if let Some(temporary) = &self.0 {
            fs::rename(temporary, path)?;
            self.0 = None;
        }
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(temporary) = &self.0 {
            // The error that led here is the one worth reporting.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Makes the renaming itself last, where folders can be synced. The new file is
/// whole in either case, so a failure is no error.
fn sync_folder(path: &Path) {
    if cfg!(unix) {
        let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        if let Ok(folder) = File::open(folder.unwrap_or(Path::new("."))) {
            let _ = folder.sync_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// A disk with room for so many bytes.
    struct Full<W> {
        room: usize,
        then: W,
    }

    impl<W: Write> Write for Full<W> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.room == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let n = self.then.write(&bytes[..bytes.len().min(self.room)])?;
            self.room -= n;
            Ok(n)
        }

        fn flush(&mut self) -> io::Result<()> {
            if self.room == 0 { Err(io::ErrorKind::StorageFull.into()) } else { self.then.flush() }
        }
    }

    fn names(folder: &Path) -> Vec<OsString> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    }

    #[test]
    fn writes_and_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.pnerf");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"newer").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"newer");
        assert_eq!(names(folder.path()), ["model.pnerf"]);
    }

    #[test]
    fn a_disk_full_at_any_byte_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.pnerf");
        let bytes = [7; 100];
        for old in [None, Some(b"old")] {
            if let Some(old) = old {
                fs::write(&path, old).unwrap();
            }
            for room in 0..=bytes.len() {
                let error = replace(&path, &bytes, |then| Full { room, then }).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::StorageFull);
                match old {
                    Some(old) => {
                        assert_eq!(fs::read(&path).unwrap(), old);
                        assert_eq!(names(folder.path()), ["model.pnerf"]);
                    }
                    None => assert!(names(folder.path()).is_empty()),
                }
            }
        }
        replace(&path, &bytes, |then| Full { room: bytes.len() + 1, then }).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }

    #[test]
    fn a_folder_in_the_way_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.pnerf");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("inside"), b"").unwrap();
        assert!(write_atomically(&path, b"bytes").is_err());
        assert_eq!(names(folder.path()), ["model.pnerf"]);
        assert!(write_atomically(folder.path().join("missing/model.pnerf"), b"").is_err());
        assert!(write_atomically("/", b"").is_err());
    }
}
