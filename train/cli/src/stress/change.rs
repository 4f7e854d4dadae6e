//! What is done to views before they are written, and to their files afterwards.

use std::io;
use std::path::Path;

use pocketnerf_train::dataset::View;
use pocketnerf_train::random::Random;

/// A change of views.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// What it is called in file names.
    pub name: &'static str,
    /// How strong it is.
    pub strength: f64,
    /// Changes the views, by random numbers that depend on the seed alone.
    pub apply: fn(&mut Vec<View>, f64, &mut Random),
}

/// A change of a written dataset's files.
#[derive(Clone, Copy, Debug)]
pub struct Damage {
    /// What it is called in file names.
    pub name: &'static str,
    /// How strong it is.
    pub strength: f64,
    /// What is done to an image file.
    pub what: fn(&Path) -> io::Result<()>,
}

impl Damage {
    /// Damages every third image file of a folder from the second on, as many as the strength
    /// says.
    ///
    /// # Errors
    /// What the system reports.
    pub fn run(&self, folder: &Path) -> io::Result<()> {
        let files = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
        let mut files: Vec<_> = files.collect::<io::Result<_>>()?;
        files.sort();
        files
            .iter()
            .skip(1)
            .step_by(3)
            .take(self.strength as usize)
            .try_for_each(|file| (self.what)(file))
    }
}

impl Change {
    /// Changes the views.
    pub fn run(&self, views: &mut Vec<View>, seed: u64) {
        // Streams of different changes differ.
        let stream =
            self.name.bytes().fold(0, |sum: u64, byte| 31 * sum % (1 << 40) + u64::from(byte));
        (self.apply)(views, self.strength, &mut Random::new(seed, [7, stream, 0]));
    }
}
