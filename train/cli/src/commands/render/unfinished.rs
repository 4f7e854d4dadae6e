//! Long work in a folder that goes on where it was interrupted.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Seconds between two notes.
const EVERY: Duration = Duration::from_millis(500);

/// A note in a folder of how far the work is, and what it is; none once it is done.
pub(super) struct Unfinished {
    file: PathBuf,
    work: u64,
    noted: Option<Instant>,
}

impl Unfinished {
    /// In a folder; `work` is all that decides about the results. Gives how many there are of the
    /// same work already.
    pub(super) fn begin(folder: &Path, work: &impl Hash) -> (Self, usize) {
        let mut hasher = DefaultHasher::new();
        work.hash(&mut hasher);
        let unfinished =
            Self { file: folder.join(".unfinished"), work: hasher.finish(), noted: None };
        let text = std::fs::read_to_string(&unfinished.file).unwrap_or_default();
        let done = text
            .strip_suffix('\n')
            .and_then(|line| line.split_once(' '))
            .filter(|(work, _)| *work == format!("{:016x}", unfinished.work))
            .and_then(|(_, done)| done.parse().ok());
        (unfinished, done.unwrap_or(0))
    }

    /// So many results are there. Not every one is noted.
    pub(super) fn note(&mut self, done: usize) {
        if self.noted.is_none_or(|noted| noted.elapsed() >= EVERY) {
            self.save(done);
        }
    }

    /// The same, at once. What cannot be noted is done again.
    pub(super) fn save(&mut self, done: usize) {
        let _ = std::fs::write(&self.file, format!("{:016x} {done}\n", self.work));
        self.noted = Some(Instant::now());
    }

    /// All are there.
    pub(super) fn end(self) {
        let _ = std::fs::remove_file(&self.file);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_work_goes_on_and_another_begins() {
        let folder = tempfile::tempdir().unwrap();
        let begin = |work: &str| Unfinished::begin(folder.path(), &work);
        let (mut first, done) = begin("a");
        assert_eq!(done, 0);
        first.note(3);
        assert_eq!(begin("a").1, 3);
        assert_eq!(begin("b").1, 0);
        // Too soon.
        first.note(4);
        assert_eq!(begin("a").1, 3);
        first.save(5);
        assert_eq!(begin("a").1, 5);
        std::fs::write(folder.path().join(".unfinished"), "half a li").unwrap();
        assert_eq!(begin("a").1, 0);
        first.end();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
