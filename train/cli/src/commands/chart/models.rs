//! The models of a chart: trained by running this program, or given.

use std::path::{Path, PathBuf};

use pocketnerf_baselines::{Baseline, Photographs, is_baseline};
use pocketnerf_core::SimdLevel;
use serde::{Deserialize, Serialize};

use super::jobs::Job;
use super::scenes::Scene;
use crate::chart::{Program, Recipe};
use crate::commands::baseline_file::open_baseline;
use crate::commands::progress::duration;
use crate::commands::stop::Stop;
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
pub(super) struct Record {
    pub(super) options: Vec<String>,
    pub(super) data: PathBuf,
    pub(super) reading: String,
    pub(super) threads: Option<u16>,
    pub(super) program: Program,
    /// `None`: not finished.
    pub(super) trained: Option<Trained>,
}

/// A model file of a scene.
pub(super) struct Model {
    pub(super) name: String,
    /// Number of the scene.
    pub(super) scene: usize,
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
    /// What is in it, where it is a baseline.
    pub(super) baseline: Option<Baseline>,
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
        let baseline = match is_baseline(&bytes) {
            true => Some(open_baseline(path, &bytes)?),
            false => None,
        };
        let origin = match &baseline {
            Some(baseline) => {
                let origin = baseline.origin();
                Some((origin.fingerprint, origin.dataset.clone()))
            }
            None => {
                let origin = open(path, &bytes)?.about.provenance;
                origin.map(|origin| (origin.trained_on, origin.dataset.to_owned()))
            }
        };
        // Fingerprints depend on the images' size, so a model of a dataset with the same name
        // is accepted.
        if let Some((trained_on, name)) = origin.filter(|(trained_on, _)| *trained_on != 0) {
            let is_of_scene = trained_on == fingerprint || name == train.name();
            if !is_of_scene {
                return Err(format!(
                    "{}: a model of {name:?}, expected one of {}; give the dataset that it was trained on",
                    path.display(),
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
        taken.push(Model {
            name,
            scene: 0,
            path,
            bytes,
            baseline,
            file_length,
            precision: None,
            trained,
            command,
        });
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
        let jobs = suitable(jobs, common)?;
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

/// Leaves out what cannot be trained on its scene, and says so.
fn suitable<'a>(jobs: Vec<Job<'a>>, common: &Common) -> Result<Vec<Job<'a>>, Failure> {
    let mut suitable = Vec::with_capacity(jobs.len());
    for job in jobs {
        let Some(method) = job.baseline()? else {
            suitable.push(job);
            continue;
        };
        match Photographs::new(job.scene.1.train_split()?, None)?.refusal(method) {
            None => suitable.push(job),
            Some(why) => common.warn(&format!("{}: left out: {why}", job.name())),
        }
    }
    Ok(suitable)
}
