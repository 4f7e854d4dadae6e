//! The models of a chart: trained by running this program, or given.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::Precision;
use pocketnerf_train::output;
use pocketnerf_train::trainer::Length;
use serde::{Deserialize, Serialize};

use super::scenes::Scene;
use crate::chart::{Program, Recipe};
use crate::commands::progress::duration;
use crate::commands::stop::{Interrupted, Stop, was_interrupted};
use crate::commands::train::{checkpoint_path, quoted};
use crate::commands::{Common, Failure, make_folder, open, read_model};

/// The cost of training a model: keys of `train --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trained {
    pub(super) seconds: f64,
    pub(super) steps: u64,
    pub(super) seed: u64,
    pub(super) peak_memory_bytes: Option<u64>,
    /// The commit that trained.
    #[serde(default)]
    pub(super) commit: Option<String>,
}

/// The record beside a model, which identifies it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Record {
    options: Vec<String>,
    data: PathBuf,
    reading: String,
    threads: Option<u16>,
    program: Program,
    /// `None`: not finished.
    trained: Option<Trained>,
}

/// A model file of a scene.
pub(super) struct Model {
    pub(super) name: String,
    /// Number of the scene.
    pub(super) scene: usize,
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
    /// Length of the file, which is packed where training wrote it.
    pub(super) file_length: usize,
    pub(super) precision: Option<&'static str>,
    pub(super) trained: Option<Trained>,
    /// The command that trains it.
    pub(super) command: Option<String>,
}

/// All models.
pub(super) struct Models {
    folder: PathBuf,
    pub(super) all: Vec<Model>,
}

/// Reads models that were given, and checks that they are of the only scene.
pub(super) fn take(paths: &[PathBuf], scenes: &[Scene]) -> Result<Vec<Model>, Failure> {
    let Some(scene) = scenes.first().filter(|_| !paths.is_empty()) else { return Ok(Vec::new()) };
    let train = scene.train_split()?;
    let fingerprint = train.fingerprint();
    let mut taken: Vec<Model> = Vec::new();
    for path in paths {
        let bytes = read_model(path)?;
        let file = open(path, &bytes)?;
        // Fingerprints depend on the images' size, so a model of a dataset with the same name
        // is accepted.
        if let Some(origin) = file.about.provenance.filter(|origin| origin.trained_on != 0) {
            let is_of_scene = origin.trained_on == fingerprint || origin.dataset == train.name();
            if !is_of_scene {
                return Err(format!(
                    "{}: a model of {:?}, expected one of {}; give the dataset that it was trained on",
                    path.display(),
                    origin.dataset,
                    scene.data.display()
                )
                .into());
            }
        }
        let name = path.file_stem().map_or_else(String::new, |stem| stem.display().to_string());
        if taken.iter().any(|other| other.name == name) {
            return Err(
                format!("{}: another model is called {name}; rename one", path.display()).into()
            );
        }
        let (path, trained, command) = (path.clone(), None, None);
        let (bytes, file_length) = (bytes.to_vec(), bytes.stored().len());
        let precision = None;
        taken.push(Model { name, scene: 0, path, bytes, file_length, precision, trained, command });
    }
    Ok(taken)
}

impl Models {
    /// In a folder for everything.
    pub(super) fn new(out: &Path, taken: Vec<Model>) -> Result<Self, Failure> {
        Ok(Self { folder: make_folder(&out.join("models"))?, all: taken })
    }

    /// Trains the missing models.
    pub(super) fn train(
        &mut self,
        scenes: &[Scene],
        recipes: &[Recipe],
        simd: Option<SimdLevel>,
        common: &Common,
        stop: &Stop,
    ) -> Result<(), Failure> {
        let jobs: Vec<Job<'_>> = (0..scenes.len())
            .flat_map(|i| recipes.iter().map(move |recipe| (i, recipe)))
            .map(|(i, recipe)| Job::new(&self.folder, (i, &scenes[i]), recipe, common))
            .collect::<Result<_, _>>()?;
        let missing: Vec<&Job<'_>> = jobs.iter().filter(|job| job.finished().is_none()).collect();
        if !common.quiet && !missing.is_empty() {
            let seconds: f64 = missing.iter().map(|job| job.seconds).sum();
            eprintln!(
                "{} of {} models to train: about {}; measuring comes on top",
                missing.len(),
                jobs.len(),
                duration(seconds)
            );
        }
        for (i, job) in missing.iter().enumerate() {
            stop.check()?;
            if !common.quiet {
                eprintln!("model {} of {}: {}", i + 1, missing.len(), job.name());
            }
            job.train(simd, common, stop)?;
        }
        for job in &jobs {
            self.all.extend(job.models()?);
        }
        Ok(())
    }
}

/// A model to train.
struct Job<'a> {
    scene: (usize, &'a Scene),
    recipe: &'a Recipe,
    /// The model as trained, in f32.
    path: PathBuf,
    record: Record,
    /// Expected seconds of training.
    seconds: f64,
}

impl<'a> Job<'a> {
    fn new(
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

    fn name(&self) -> String {
        format!("{} {}", self.scene.1.name, self.recipe.options.join(" "))
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
    fn finished(&self) -> Option<Trained> {
        self.recorded()?.trained.filter(|_| self.path.is_file())
    }

    fn write_record(&self, trained: Option<Trained>) -> Result<(), Failure> {
        let record = Record { trained, ..self.record.clone() };
        Ok(output::write_atomic(&self.record_path(), &serde_json::to_vec_pretty(&record)?)?)
    }

    /// Runs `pocketnerf train` as users do, so that time and memory are those of the whole
    /// program.
    fn train(&self, simd: Option<SimdLevel>, common: &Common, stop: &Stop) -> Result<(), Failure> {
        let checkpoint = checkpoint_path(&self.path);
        let resumes = checkpoint.is_file() && self.recorded().is_some();
        if !resumes && checkpoint.is_file() {
            // Of other options: it must not be resumed.
            std::fs::remove_file(&checkpoint)?;
        }
        self.write_record(None)?;
        let mut command = crate::host::program()?;
        command.arg("train").arg(&self.record.data).arg("--out").arg(&self.path);
        command.args(["--precision", "f32", "--json"]);
        if resumes {
            command.arg("--resume").arg(&checkpoint).args(self.given_again());
        } else {
            command.args(&self.recipe.options);
        }
        command.args(self.record.reading.split_whitespace());
        if let Some(threads) = common.threads {
            command.args(["--threads", &threads.to_string()]);
        }
        if let Some(simd) = simd {
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
    fn models(&self) -> Result<Vec<Model>, Failure> {
        let trained = self.finished();
        let source = read_model(&self.path)?;
        let file = open(&self.path, &source)?;
        let whole = self.recipe.precisions.iter().map(|precision| {
            let name = precision_name(*precision);
            let path = self.path.with_extension("").with_extension(format!("{name}.pnerf"));
            let bytes = pocketnerf_formats::write(&file.model, &file.about, *precision)?;
            let packed = pocketnerf_formats::pack(&bytes)?;
            if *precision != Precision::F32 {
                output::write_atomic(&path, &packed)?;
            }
            let command = format!(
                "pocketnerf train {} --out scene.pnerf{}{} --precision {name}",
                quoted(&self.record.data),
                self.recipe.options.iter().map(|o| format!(" {o}")).collect::<String>(),
                self.record.reading,
            );
            Ok(Model {
                name: self.recipe.name.clone(),
                scene: self.scene.0,
                path,
                bytes,
                file_length: packed.len(),
                precision: Some(name),
                trained: trained.clone(),
                command: Some(command),
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
