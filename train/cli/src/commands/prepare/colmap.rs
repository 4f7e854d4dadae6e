//! What COLMAP is asked to do.

use std::path::Path;

use crate::commands::progress::Progress;
use crate::commands::tool::{COLMAP, Runner};
use crate::commands::{Common, Failure};

/// Photographs are made this small for finding features: what is finer takes longer, and gives
/// hardly better cameras.
const LARGEST: u32 = 1600;
/// Frames that are compared with so many that follow.
const OVERLAP: u32 = 12;

/// Which photographs are compared with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Matcher {
    /// Each with each
    Exhaustive,
    /// Each with those that follow, as frames of a video
    Sequential,
}

/// The files of a run.
pub(super) struct Colmap<'a> {
    pub(super) images: &'a Path,
    pub(super) database: &'a Path,
    pub(super) n_images: usize,
    /// The most of a photograph.
    pub(super) features: u32,
    pub(super) threads: Option<u16>,
    pub(super) common: &'a Common,
    pub(super) runner: &'a Runner<'a>,
}

/// Options that a command has by its help; names differ between versions of COLMAP.
struct Options {
    help: String,
    given: Vec<String>,
}

impl Options {
    fn of(command: &str) -> Result<Self, Failure> {
        Ok(Self { help: COLMAP.ask(&[command, "--help"])?, given: vec![command.to_owned()] })
    }

    fn with(mut self, option: &str, value: impl ToString) -> Self {
        self.given.extend([format!("--{option}"), value.to_string()]);
        self
    }

    /// The option of this name in any group: `use_gpu` is `SiftExtraction.use_gpu`, or
    /// `FeatureExtraction.use_gpu` since COLMAP 3.13.
    fn with_any(self, name: &str, value: impl ToString) -> Self {
        let ending = format!(".{name}");
        let words = self.help.split_whitespace().filter_map(|word| word.strip_prefix("--"));
        let found = words.map(str::to_owned).find(|word| word.ends_with(&ending));
        match found {
            Some(option) => self.with(&option, value),
            None => self,
        }
    }
}

impl Colmap<'_> {
    /// Features of all images; `one_camera`: they were taken by one, with one lens and zoom.
    pub(super) fn features(&self, one_camera: bool) -> Result<(), Failure> {
        // What was half done is done again.
        for ending in ["", "-shm", "-wal"] {
            let mut file = self.database.as_os_str().to_owned();
            file.push(ending);
            let file = Path::new(&file);
            if file.exists() {
                std::fs::remove_file(file).map_err(|e| format!("{}: {e}", file.display()))?;
            }
        }
        let model = if one_camera { "OPENCV" } else { "SIMPLE_RADIAL" };
        let options = Options::of("feature_extractor")?
            .with("image_path", self.images.display())
            .with("database_path", self.database.display())
            .with("ImageReader.camera_model", model)
            .with("ImageReader.single_camera", u8::from(one_camera))
            .with_any("max_image_size", LARGEST)
            .with_any("max_num_features", self.features);
        self.run(options, "finding features", self.n_images)
    }

    /// Matches between them.
    pub(super) fn matches(&self, matcher: Matcher) -> Result<(), Failure> {
        let options = match matcher {
            Matcher::Exhaustive => Options::of("exhaustive_matcher")?,
            Matcher::Sequential => {
                Options::of("sequential_matcher")?.with("SequentialMatching.overlap", OVERLAP)
            }
        };
        let options = options.with("database_path", self.database.display());
        self.run(options, "matching photographs", self.n_images)
    }

    /// Cameras and points: models in `to`, as 0, 1, ...
    pub(super) fn model(&self, to: &Path) -> Result<(), Failure> {
        let options = Options::of("mapper")?
            .with("image_path", self.images.display())
            .with("database_path", self.database.display())
            .with("output_path", to.display());
        self.run(options, "finding cameras", self.n_images)
    }

    fn run(&self, options: Options, what: &'static str, all: usize) -> Result<(), Failure> {
        let options = match has_cuda()? {
            true => options,
            false => options.with_any("use_gpu", 0),
        };
        let options = match self.threads {
            Some(threads) => options.with_any("num_threads", threads),
            None => options,
        };
        let mut progress = Progress::new(what, all, self.common);
        self.runner.run(COLMAP, &options.given, |line| {
            if let Some(n) = done_of(line) {
                progress.done(n.min(all));
            }
        })
    }
}

/// Whether this build of COLMAP says that it uses GPUs.
fn has_cuda() -> Result<bool, Failure> {
    Ok(COLMAP.ask(&["help"])?.contains("with CUDA"))
}

/// How many images are done: `Processed file [3/30]`, `Matching image [3/30]`, `Registering image #7
/// (3)`.
fn done_of(line: &str) -> Option<usize> {
    if let Some((_, rest)) = line.split_once("Registering image #") {
        return rest.split_once('(')?.1.split_once(')')?.0.parse().ok();
    }
    let (_, rest) = line.split_once("file [").or_else(|| line.split_once("image ["))?;
    rest.split_once('/')?.0.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_done() {
        for (line, done) in [
            ("Processed file [3/30]", Some(3)),
            ("I20240101 feature_extraction.cc:254] Processed file [12/30]", Some(12)),
            ("Registering image #7 (23)", Some(23)),
            ("Matching image [5/30]", Some(5)),
            ("Matching block [1/2, 1/2]", None),
            ("  Name: 0003.jpg", None),
        ] {
            assert_eq!(done_of(line), done, "{line}");
        }
    }

    #[test]
    fn options_of_either_version() {
        for (help, expected) in [
            ("  --SiftExtraction.use_gpu arg (=1)", &["c", "--SiftExtraction.use_gpu", "0"][..]),
            ("  --FeatureExtraction.use_gpu arg", &["c", "--FeatureExtraction.use_gpu", "0"]),
            ("  --image_path arg", &["c"]),
        ] {
            let options = Options { help: help.to_owned(), given: vec!["c".to_owned()] };
            assert_eq!(options.with_any("use_gpu", 0).given, expected);
        }
    }
}
