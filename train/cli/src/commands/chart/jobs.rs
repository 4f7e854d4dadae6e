//! A model that a chart trains, by running this program.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use pocketnerf_baselines::Method;
use pocketnerf_core::SimdLevel;
use pocketnerf_formats::Precision;
use pocketnerf_train::output;
use pocketnerf_train::trainer::Length;

use super::models::{Model, Record, Trained};
use super::scenes::Scene;
use crate::chart::{Program, Recipe};
use crate::commands::baseline_file::open_baseline;
use crate::commands::stop::{Interrupted, Stop, was_interrupted};
use crate::commands::train::{checkpoint_path, quoted};
use crate::commands::{Common, Failure, open, read_model};

/// A model to train.
pub(super) struct Job<'a> {
    pub(super) scene: (usize, &'a Scene),
    recipe: &'a Recipe,
    /// The model as trained, in f32.
    path: PathBuf,
    record: Record,
    /// Expected seconds of training.
    pub(super) seconds: f64,
}

impl<'a> Job<'a> {
    pub(super) fn new(
        folder: &Path,
        scene: (usize, &'a Scene),
        recipe: &'a Recipe,
        common: &Common,
    ) -> Result<Self, Failure> {
        let record = Record {
            options: recipe.options.clone(),
            data: scene.1.data.clone(),
            reading: scene.1.reading.given(),
            threads: common.threads,
            program: Program::this(),
            trained: None,
        };
        let seconds = match super::plan::length(recipe)? {
            Length::Seconds(seconds) => seconds,
            Length::Steps(steps) => f64::from(steps) / 100.0,
        };
        let path = folder.join(format!("{}.{}.f32.pnerf", scene.1.name, recipe.name));
        Ok(Self { scene, recipe, path, record, seconds })
    }

    pub(super) fn name(&self) -> String {
        format!("{} {}", self.scene.1.name, self.recipe.options.join(" "))
    }

    /// The baseline that is trained, if it is one.
    pub(super) fn baseline(&self) -> Result<Option<Method>, Failure> {
        super::plan::baseline(self.recipe)
    }

    fn record_path(&self) -> PathBuf {
        self.path.with_extension("json")
    }

    /// The record of a model with these options, whichever version trained it: the chart names
    /// that version.
    fn recorded(&self) -> Option<Record> {
        let bytes = std::fs::read(self.record_path()).ok()?;
        let found: Record = serde_json::from_slice(&bytes).ok()?;
        let expected = Record {
            program: found.program.clone(),
            trained: found.trained.clone(),
            ..self.record.clone()
        };
        (found == expected).then_some(found)
    }

    /// The cost of training, if it is done.
    pub(super) fn finished(&self) -> Option<Trained> {
        self.recorded()?.trained.filter(|_| self.path.is_file())
    }

    fn write_record(&self, trained: Option<Trained>) -> Result<(), Failure> {
        let record = Record { trained, ..self.record.clone() };
        Ok(output::write_atomic(&self.record_path(), &serde_json::to_vec_pretty(&record)?)?)
    }

    /// Runs `pocketnerf train` as users do, so that time and memory are those of the whole
    /// program.
    pub(super) fn train(
        &self,
        simd: Option<SimdLevel>,
        common: &Common,
        stop: &Stop,
    ) -> Result<(), Failure> {
        let checkpoint = checkpoint_path(&self.path);
        let resumes = checkpoint.is_file() && self.recorded().is_some();
        if !resumes && checkpoint.is_file() {
            // Of other options: it must not be resumed.
            std::fs::remove_file(&checkpoint)?;
        }
        self.write_record(None)?;
        let mut command = crate::host::program()?;
        command.arg("train").arg(&self.record.data).arg("--out").arg(&self.path);
        let is_baseline = self.baseline()?.is_some();
        if !is_baseline {
            command.args(["--precision", "f32"]);
        }
        command.arg("--json");
        if resumes {
            command.arg("--resume").arg(&checkpoint).args(self.given_again());
        } else {
            command.args(&self.recipe.options);
        }
        command.args(self.record.reading.split_whitespace());
        if let Some(threads) = common.threads {
            command.args(["--threads", &threads.to_string()]);
        }
        if let Some(simd) = simd.filter(|_| !is_baseline) {
            command.args(["--simd", simd.name()]);
        }
        if common.quiet {
            command.arg("--quiet");
        }
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?;
        stop.child(Some(&child));
        let output = child.wait_with_output();
        stop.child(None);
        let output = output?;
        if !output.status.success() {
            // A terminal signals both, in any order.
            stop.check()?;
            if was_interrupted(output.status) {
                return Err(Interrupted.into());
            }
            let (name, status) = (self.name(), output.status);
            return Err(format!("{name}: training failed ({status}), for the reason above").into());
        }
        let trained: Trained = serde_json::from_slice(&output.stdout)?;
        let commit = self.record.program.commit.clone();
        self.write_record(Some(Trained { commit, ..trained }))?;
        if checkpoint.exists() {
            std::fs::remove_file(checkpoint)?;
        }
        Ok(())
    }

    /// Options that a checkpoint does not store.
    fn given_again(&self) -> &[String] {
        let options = &self.recipe.options;
        match options.iter().position(|option| option == "--views") {
            Some(i) => &options[i..(i + 2).min(options.len())],
            None => &[],
        }
    }

    /// The model in each precision, on disk and in memory.
    pub(super) fn models(&self) -> Result<Vec<Model>, Failure> {
        let trained = self.finished();
        let source = read_model(&self.path)?;
        let command = format!(
            "pocketnerf train {} --out scene.pnerf{}{}",
            quoted(&self.record.data),
            self.recipe.options.iter().map(|o| format!(" {o}")).collect::<String>(),
            self.record.reading,
        );
        if self.baseline()?.is_some() {
            return Ok(vec![Model {
                name: self.recipe.name.clone(),
                scene: self.scene.0,
                path: self.path.clone(),
                baseline: Some(open_baseline(&self.path, &source)?),
                file_length: source.len(),
                bytes: source.to_vec(),
                precision: None,
                trained,
                command: Some(command),
            }]);
        }
        let file = open(&self.path, &source)?;
        let whole = self.recipe.precisions.iter().map(|precision| {
            let name = precision_name(*precision);
            let path = self.path.with_extension("").with_extension(format!("{name}.pnerf"));
            let bytes = pocketnerf_formats::write(&file.model, &file.about, *precision)?;
            let packed = pocketnerf_formats::pack(&bytes)?;
            if *precision != Precision::F32 {
                output::write_atomic(&path, &packed)?;
            }
            Ok(Model {
                name: self.recipe.name.clone(),
                scene: self.scene.0,
                path,
                bytes,
                baseline: None,
                file_length: packed.len(),
                precision: Some(name),
                trained: trained.clone(),
                command: Some(format!("{command} --precision {name}")),
            })
        });
        whole.collect()
    }
}

const fn precision_name(precision: Precision) -> &'static str {
    match precision {
        Precision::I8 => "i8",
        Precision::F16 => "f16",
        Precision::F32 => "f32",
    }
}
