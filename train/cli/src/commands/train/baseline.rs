//! Training of baselines.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pocketnerf_baselines::{BaselineError, Method, Origin, Photographs, Run, is_baseline};
use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::output;
use pocketnerf_train::trainer::Size;
use serde_json::{Value, json};

use super::saving::{Interrupted, Resume, Saving};
use super::{Bar, Train, checkpoint_path, report};
use crate::commands::stop::Stop;
use crate::commands::{Common, Failure, memory};

/// What a run of a baseline begins with.
pub(super) enum Begin {
    New(Method),
    /// The bytes of a checkpoint.
    Resumed(PathBuf, Vec<u8>),
}

impl Train {
    /// The baseline that is to be trained, if it is one.
    pub(super) fn baseline(&self) -> Result<Option<Begin>, Failure> {
        let begin = match (&self.resume, self.model.baseline()) {
            (Some(checkpoint), _) if is_of_baseline(checkpoint) => {
                let failure = |e| format!("{}: cannot be read: {e}", checkpoint.display());
                let bytes = std::fs::read(checkpoint).map_err(failure)?;
                Begin::Resumed(checkpoint.clone(), bytes)
            }
            (None, Some(method)) => Begin::New(method),
            _ => return Ok(None),
        };
        let for_fields = [
            ("--precision", self.precision != Precision::I8),
            ("--batch-rays", self.batch_rays.is_some()),
            ("--simd", self.vectors.simd.is_some()),
            ("--view", self.watch.is_asked()),
            ("--up, --scale", self.world.is_given()),
        ];
        let given = for_fields.iter().find(|(_, given)| *given).map(|(option, _)| *option);
        let given = given.or(self.scene.given_for_fields()).or(self.model.given_for_fields());
        match given {
            Some(option) => Err(format!("{option}: baselines have no such option").into()),
            None => Ok(Some(begin)),
        }
    }

    /// The baseline that `--method` names, if it is one.
    pub(in crate::commands) fn baseline_method(&self) -> Option<Method> {
        self.model.baseline()
    }

    pub(super) fn train_baseline(&self, begin: Begin, common: &Common) -> Result<(), Failure> {
        let outcome = "interrupted before the first step; there is nothing to save";
        let stop = Stop::listen(common, outcome)?;
        let saved = checkpoint_path(&self.out);
        output::check_output(&self.out)?;
        output::check_output(&saved)?;
        let mut bar = Bar::new(common);
        let (photographs, mut run) = self.begin_baseline(begin, common, &mut bar)?;
        if self.device.is_gpu() {
            bar.warn("--device gpu: baselines have no program for GPUs; the CPU trains".to_owned());
        }
        let every = self.save_every.map(Duration::from_secs_f64);
        let mut saving = Saving::begin(saved, every, stop);
        bar.phase("training");
        while let Some(progress) = run.step(&photographs)? {
            bar.show(&progress);
            let checkpoint = || Ok(run.checkpoint());
            if let Some(checkpoint) = saving.after_step(run.is_over(), checkpoint, &mut bar)? {
                return Err(
                    Interrupted { step: run.steps(), resume: self.again(checkpoint) }.into()
                );
            }
        }
        bar.phase("writing the file");
        let baseline = run.finish()?;
        if let Some(doubt) = baseline.doubt() {
            bar.warn(doubt);
        }
        let bytes = baseline.to_bytes();
        let replaced = self.out.exists();
        output::write_atomic(&self.out, &bytes)?;
        saving.at_end(|| Ok(run.checkpoint()), &mut bar);
        let result = result(&run, (bytes.len(), replaced), &self.out, bar.warnings());
        drop(bar);
        report(result, common);
        Ok(())
    }

    /// The photographs and the run, new or resumed.
    fn begin_baseline(
        &self,
        begin: Begin,
        common: &Common,
        bar: &mut Bar,
    ) -> Result<(Photographs, Run), Failure> {
        let started = common.started;
        match begin {
            Begin::New(method) => {
                let factor = self.downscale_factor();
                let dataset = self.photographs(true, factor, common, bar)?;
                let origin = Origin::of(&dataset, self.seed.unwrap_or(0), factor);
                let photographs = self.placed(dataset, self.scene.background)?;
                let run = Run::new(method, &photographs, origin, self.length(), started);
                let run = run.map_err(|error| self.of_data(error))?;
                Ok((photographs, run))
            }
            Begin::Resumed(path, bytes) => {
                let of_file = |error| format!("{}: {error}", path.display());
                let stored = Run::read(&bytes).map_err(of_file)?;
                let given = [
                    ("--method", self.model.has_method()),
                    ("--seconds, --steps", self.seconds.is_some() || self.steps.is_some()),
                    ("--seed", self.seed.is_some()),
                    ("--downscale-factor", self.downscale_factor.is_some()),
                    ("--background", self.scene.background.is_some()),
                    ("--aabb", self.scene.aabb.is_some()),
                    ("--near", self.scene.near.is_some()),
                    ("--far", self.scene.far.is_some()),
                ];
                if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
                    return Err(format!("{option}: the checkpoint knows; leave it out").into());
                }
                let factor = stored.origin().downscale_factor;
                let dataset = self.photographs(false, factor, common, bar)?;
                let origin = Origin::of(&dataset, stored.origin().seed, factor);
                let photographs = Photographs::at(dataset, stored.place()).map_err(of_file)?;
                let run = stored.resume(&origin, started).map_err(of_file)?;
                Ok((photographs, run))
            }
        }
    }

    /// Photographs, and where the options say that the scene is.
    fn placed(
        &self,
        mut dataset: Dataset,
        background: Option<[f32; 3]>,
    ) -> Result<Photographs, Failure> {
        let given = self.scene.aabb.map(|corners| dataset.box_as_read(corners));
        dataset.aabb = given.or(dataset.aabb);
        let photographs =
            Photographs::new(dataset, background).map_err(|error| self.of_data(error))?;
        Ok(photographs.between(self.scene.near, self.scene.far))
    }

    /// What is wrong with the dataset, with its name.
    fn of_data(&self, error: BaselineError) -> String {
        format!("{}: {error}", self.data.display())
    }

    /// The command that goes on.
    fn again(&self, checkpoint: PathBuf) -> Resume {
        Resume {
            checkpoint,
            data: self.data.clone(),
            out: self.out.clone(),
            precision: Precision::I8,
            size: Size::Whole,
            reading: self.reading,
            views: self.views,
        }
    }
}

/// Whether a file begins as a baseline's. What is wrong with other files is said where they are
/// read.
fn is_of_baseline(path: &Path) -> bool {
    let mut start = [0; 8];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && is_baseline(&start)
}

/// What `train --json` prints.
fn result(run: &Run, (bytes, replaced): (usize, bool), out: &Path, warnings: &[String]) -> Value {
    json!({
        "seconds": run.elapsed(),
        "steps": run.steps(),
        "restarts": 0,
        "train_psnr": run.train_psnr(),
        "held_out_psnr": null,
        "held_out_psnr_min": null,
        "bytes": bytes,
        "replaced": replaced,
        "peak_memory_bytes": memory::peak(),
        "seed": run.origin().seed,
        "device": "cpu",
        "threads": rayon::current_num_threads(),
        "method": run.method().name(),
        "warnings": warnings,
        "out": out.display().to_string(),
    })
}
