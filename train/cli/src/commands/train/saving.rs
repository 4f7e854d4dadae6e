//! When a run is saved, and how it is interrupted.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use pocketnerf_formats::Precision;
use pocketnerf_train::output;
use pocketnerf_train::trainer::{Run, Size, Trainer, checkpoint};

use super::{Bar, Origin};
use crate::commands::stop::Stop;
use crate::commands::{Failure, Reading};

/// Where and when checkpoints are written.
pub(super) struct Saving {
    path: PathBuf,
    every: Option<Duration>,
    last: Instant,
    stop: Stop,
    /// Whether the user knows that checkpoints fail.
    warned: bool,
}

impl Saving {
    /// From now on there is something to save.
    pub(super) fn begin(path: PathBuf, every: Option<Duration>, stop: Stop) -> Self {
        stop.defer();
        Self { path, every, last: Instant::now(), stop, warned: false }
    }

    /// Whether the user wants the command to end.
    pub(super) fn is_asked_to_stop(&self) -> bool {
        self.stop.is_asked()
    }

    /// Saves if it is time to, or if the run is to stop and `is_over` is false: then it stops
    /// here, and the result is where it is saved. `checkpoint` gives the bytes.
    pub(super) fn after_step(
        &mut self,
        is_over: bool,
        checkpoint: impl Fn() -> Result<Vec<u8>, Failure>,
        bar: &mut Bar,
    ) -> Result<Option<PathBuf>, Failure> {
        if self.stop.is_asked() && !is_over {
            return self.rescue(&checkpoint()?).map(Some);
        }
        if self.every.is_some_and(|every| self.last.elapsed() >= every) {
            self.save_or_warn(checkpoint(), bar);
        }
        Ok(None)
    }

    /// Writes the last checkpoint, of the whole run, if checkpoints are wanted: it holds the
    /// model in f32.
    pub(super) fn at_end(
        &mut self,
        checkpoint: impl Fn() -> Result<Vec<u8>, Failure>,
        bar: &mut Bar,
    ) {
        if self.every.is_some() {
            self.save_or_warn(checkpoint(), bar);
        }
    }

    /// Saves a run that ends here, beside the model or else in the folder for temporary files,
    /// and returns where: a full disk must not cost hours of training.
    pub(super) fn rescue(&self, checkpoint: &[u8]) -> Result<PathBuf, Failure> {
        let Err(failure) = output::write_atomic(&self.path, checkpoint) else {
            return Ok(self.path.clone());
        };
        // With a number, so that it replaces no other run's.
        let name = self.path.file_name().unwrap_or_default().display();
        let other = std::env::temp_dir().join(format!("{}-{name}", std::process::id()));
        match output::write_atomic(&other, checkpoint) {
            Ok(()) => Ok(other),
            Err(second) => Err(format!("{failure}; {second}; the run is lost").into()),
        }
    }

    /// A checkpoint that cannot be written while training goes on is no reason to stop: the
    /// next one may succeed.
    fn save_or_warn(&mut self, checkpoint: Result<Vec<u8>, Failure>, bar: &mut Bar) {
        let written = checkpoint.and_then(|bytes| Ok(output::write_atomic(&self.path, &bytes)?));
        self.last = Instant::now();
        if let Err(failure) = written
            && !std::mem::replace(&mut self.warned, true)
        {
            bar.warn(format!("{failure}; training continues without this checkpoint"));
        }
    }
}

/// The bytes of a checkpoint.
pub(super) fn checkpoint(
    trainer: &Trainer,
    run: &Run,
    origin: &Origin,
) -> Result<Vec<u8>, Failure> {
    let about = origin.about(trainer, run);
    Ok(checkpoint::write(trainer, run, origin.trained_on, &about)?)
}

/// The checkpoint of a run, beside its model: `scene.pnerf` → `scene.ckpt.pnerf`.
pub(in crate::commands) fn checkpoint_path(out: &Path) -> PathBuf {
    out.with_extension("ckpt.pnerf")
}

/// Training was interrupted and saved.
#[derive(Debug)]
pub(in crate::commands) struct Interrupted {
    pub(super) step: u32,
    pub(super) resume: Resume,
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "interrupted at step {}, saved; resume with: {}", self.step, self.resume)
    }
}

impl std::error::Error for Interrupted {}

impl Interrupted {
    /// Where the run is saved.
    pub(in crate::commands) fn checkpoint(&self) -> PathBuf {
        self.resume.checkpoint.clone()
    }
}

/// Training is done and saved, but there is no model.
#[derive(Debug)]
pub(in crate::commands) struct Unfinished {
    pub(super) reason: Failure,
    pub(super) resume: Resume,
}

impl fmt::Display for Unfinished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; training is saved, write the model with: {}", self.reason, self.resume)
    }
}

impl std::error::Error for Unfinished {}

impl Unfinished {
    /// Where the run is saved.
    pub(in crate::commands) fn checkpoint(&self) -> PathBuf {
        self.resume.checkpoint.clone()
    }
}

/// The command that goes on from a checkpoint.
#[derive(Debug)]
pub(super) struct Resume {
    pub(super) checkpoint: PathBuf,
    pub(super) data: PathBuf,
    pub(super) out: PathBuf,
    pub(super) precision: Precision,
    /// How large the model file is to be.
    pub(super) size: Size,
    pub(super) reading: Reading,
    /// Views to train on, if not all.
    pub(super) views: Option<u32>,
}

impl fmt::Display for Resume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [data, out, checkpoint] = [&self.data, &self.out, &self.checkpoint].map(|p| quoted(p));
        write!(f, "pocketnerf train {data} --out {out} --resume {checkpoint}")?;
        // The checkpoint stores neither how the dataset is read nor how the model is written.
        f.write_str(&self.reading.given())?;
        if let Some(views) = self.views {
            write!(f, " --views {views}")?;
        }
        match self.size {
            Size::Whole => {}
            Size::Bytes(most) => write!(f, " --max-bytes {most}")?,
            Size::HeldOut(psnr) => write!(f, " --target-psnr {psnr}")?,
            Size::Near => write!(f, " --auto")?,
        }
        match self.precision {
            Precision::I8 => Ok(()),
            Precision::F16 => write!(f, " --precision f16"),
            Precision::F32 => write!(f, " --precision f32"),
        }
    }
}

/// A path, quoted for a shell.
pub(in crate::commands) fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/\\._-+=:,@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_lie_beside_models() {
        let path = |out: &str| checkpoint_path(Path::new(out)).display().to_string();
        assert_eq!(path("a/scene.pnerf"), "a/scene.ckpt.pnerf");
        assert_eq!(path("scene"), "scene.ckpt.pnerf");
        assert_eq!(path("a.b/scene.ckpt.pnerf"), "a.b/scene.ckpt.ckpt.pnerf");
    }

    #[test]
    fn the_line_can_be_pasted() {
        let resume = Resume {
            checkpoint: "my scene.ckpt.pnerf".into(),
            data: "it's".into(),
            out: "m.pnerf".into(),
            precision: Precision::F16,
            size: Size::Bytes(500_000),
            reading: Reading { hold_every: 4, spherify: true },
            views: Some(9),
        };
        let interrupted = Interrupted { step: 7, resume };
        assert_eq!(
            interrupted.to_string(),
            "interrupted at step 7, saved; resume with: pocketnerf train 'it'\\''s' \
             --out m.pnerf --resume 'my scene.ckpt.pnerf' --hold-every 4 --spherify --views 9 \
             --max-bytes 500000 --precision f16"
        );
    }
}
