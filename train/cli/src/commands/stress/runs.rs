//! Runs of this program, as users start them: what is trained and what is seen of it, kept in
//! files with what they depend on.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use pocketnerf_baselines::is_baseline;
use pocketnerf_core::Camera;
use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{self, Dataset, Split};
use pocketnerf_train::output;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Stress;
use super::place::Place;
use super::scene::SpoiltScene;
use crate::chart::Program;
use crate::commands::baseline_file::open_baseline;
use crate::commands::progress::duration;
use crate::commands::stop::{Interrupted, Stop, was_interrupted};
use crate::commands::train::Method;
use crate::commands::{Common, Failure, make_folder, open, read_model};
use crate::stress::{Context, Training, Viewing, modes::cameras};

/// What training came to.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Trained {
    /// All that it depends on.
    of: String,
    /// Why the program refused.
    refused: Option<String>,
    /// What it said.
    said: Vec<String>,
}

/// What was seen of a model.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Seen {
    of: String,
    pub(super) psnr: Option<f64>,
    pub(super) psnr_min: Option<f64>,
    /// What the program said in training and comparing.
    said: Vec<String>,
    /// The worst view: model, truth, difference.
    pub(super) picture: Option<PathBuf>,
}

impl Seen {
    /// What was said here and not there, but for numbers and names.
    pub(super) fn said_beside(&self, reference: &Self) -> Vec<String> {
        let alike = |line: &String| -> String {
            let text = line.rsplit_once("/").map_or(&line[..], |(_, rest)| rest);
            text.chars().filter(|c| !c.is_ascii_digit() && *c != '.').collect()
        };
        let known: Vec<String> = reference.said.iter().map(alike).collect();
        self.said.iter().filter(|line| !known.contains(&alike(line))).cloned().collect()
    }
}

/// Runs for a scene and a method.
pub(super) struct Runs<'a> {
    stress: &'a Stress,
    scene: &'a SpoiltScene,
    method: Method,
    common: &'a Common,
    stop: &'a Stop,
    folder: PathBuf,
    /// What all runs depend on.
    shared: String,
    /// Seconds of the first run, where it was not kept.
    first: Option<f64>,
}

impl<'a> Runs<'a> {
    pub(super) fn new(
        stress: &'a Stress,
        scene: &'a SpoiltScene,
        method: Method,
        common: &'a Common,
        stop: &'a Stop,
    ) -> Result<Self, Failure> {
        let folder = make_folder(&stress.out().join(format!("{}.{}", scene.name, method.name())))?;
        let fingerprint = scene.load(Split::Train, 0)?.fingerprint();
        let shared = format!(
            "{fingerprint:016x} {} {:?} {:?} {} {}",
            scene.factor,
            common.threads,
            stress.vectors.level(),
            stress.steps(),
            Program::this().commit.unwrap_or_default(),
        );
        Ok(Self { stress, scene, method, common, stop, folder, shared, first: None })
    }

    /// What cases depend on, after the unspoilt scene is trained.
    pub(super) fn context(&mut self) -> Result<Context, Failure> {
        let begun = Instant::now();
        let usual = self.folder.join("usual.pnerf");
        let kept = usual.is_file();
        let seen = self.look(&Training::default(), &Viewing::default(), 0)?;
        self.first = (!kept).then(|| begun.elapsed().as_secs_f64());
        if seen.psnr.is_none() {
            let why = seen.said.first().cloned().unwrap_or_default();
            return Err(format!("{}: unspoilt, it does not train: {why}", self.scene.name).into());
        }
        let bytes = read_model(&usual)?;
        let space = match is_baseline(&bytes) {
            true => open_baseline(&usual, &bytes)?.space(),
            false => open(&usual, &bytes)?.model.space,
        };
        let aabb = space.scene_box().map(|_| space.bounds());
        let train = self.scene.load(Split::Train, 0)?;
        Ok(Context {
            aabb,
            distance: f64::from(cameras::distance(&train.views)),
            steps: self.stress.steps(),
            downscale_factor: self.scene.factor,
            entries: self.method.entries(),
            has_alpha: train.has_alpha,
            forward_facing: train.forward_facing,
            still_life: self.scene.is_still_life(),
        })
    }

    /// How long so many cases take, as far as that is known.
    pub(super) fn expected(&self, cases: usize) -> String {
        let first =
            self.first.map(|seconds| format!(", about {}", duration(seconds * cases as f64)));
        first.unwrap_or_default()
    }

    /// What is seen of what was trained; kept, or new.
    pub(super) fn look(
        &mut self,
        training: &Training,
        viewing: &Viewing,
        seed: u64,
    ) -> Result<Seen, Failure> {
        let training = Training { seed: training.seed + seed, ..training.clone() };
        let (id, view) = (training.id(), viewing.id());
        let path = self.folder.join(format!("{id}.{view}.json"));
        let of = format!("{} {id} {view}", self.shared);
        if let Some(seen) = read::<Seen>(&path).filter(|seen| seen.of == of) {
            return Ok(seen);
        }
        let place = Place::new(&self.folder, self.scene, &training);
        let trained = self.train(&training, &place)?;
        let mut seen = Seen { of, said: trained.said.clone(), ..Seen::default() };
        match trained.refused {
            Some(why) => seen.said.push(why),
            None => self.compare(viewing, &place, &view, &mut seen)?,
        }
        write(&path, &seen)?;
        if let Some(folder) = place.written.filter(|_| id != Training::default().id()) {
            std::fs::remove_dir_all(&folder)
                .map_err(|error| format!("{}: cannot be removed: {error}", folder.display()))?;
        }
        Ok(seen)
    }

    /// Trains, unless that is done.
    fn train(&self, training: &Training, place: &Place) -> Result<Trained, Failure> {
        let of = format!("{} {}", self.shared, training.id());
        if let Some(folder) = &place.written {
            self.write_photos(training, folder)?;
        }
        let record = place.model.with_extension("json");
        let kept = read::<Trained>(&record).filter(|trained| trained.of == of);
        if let Some(trained) = kept.filter(|t| t.refused.is_some() || place.model.is_file()) {
            return Ok(trained);
        }
        let mut said = Vec::new();
        if let Some(folder) = &place.written {
            let mut info = self.program("info")?;
            info.arg(folder);
            said.extend(warnings(&self.run(info)?));
        }
        let mut command = self.program("train")?;
        command.arg(&place.data).arg("--out").arg(&place.model);
        command
            .args(["--steps", &training.steps.unwrap_or_else(|| self.stress.steps()).to_string()]);
        command.args(["--seed", &training.seed.to_string()]);
        command.args(self.method.small()).args(&training.options).args(&place.options);
        let output = self.run(command)?;
        said.extend(warnings(&output));
        let text = String::from_utf8_lossy(&output.stderr);
        let last = text.lines().last().unwrap_or("no reason was given").to_owned();
        let refused = match output.status.code() {
            Some(0) => None,
            Some(1) => Some(last),
            // It was killed, or panicked.
            _ => return Err(format!("{}: {}: {last}", training.id(), output.status).into()),
        };
        let trained = Trained { of, refused, said };
        write(&record, &trained)?;
        Ok(trained)
    }

    /// Compares with the truth.
    fn compare(
        &self,
        viewing: &Viewing,
        place: &Place,
        view: &str,
        seen: &mut Seen,
    ) -> Result<(), Failure> {
        let mut command = self.program("eval")?;
        command.arg(&place.model).arg(&place.data);
        if let Some(folder) = &place.written {
            let mut truth = self.scene.load(Split::Test, viewing.smaller)?;
            if let Some(change) = place.all {
                change.run(&mut truth.views, 0);
            }
            if let Some(change) = viewing.change {
                change.run(&mut truth.views, 0);
            }
            if let Some(distance) = viewing.distance {
                let n = truth.views.len();
                let cameras = Scene::StillLife.cameras(n, distance as f32);
                let cameras: Vec<Camera> =
                    cameras.iter().map(|camera| camera.downscaled(self.scene.factor)).collect();
                truth.views = Scene::StillLife.views(&cameras, "distance");
            }
            if truth.views.is_empty() {
                seen.said.push("no test view is there".to_owned());
                return Ok(());
            }
            dataset::write(folder, Split::Test, &truth.views)?;
        } else {
            command.args(&place.options);
        }
        let pictures = self.folder.join("pictures");
        command.arg("--out").arg(&pictures).args(&viewing.options);
        let output = self.run(command)?;
        if !output.status.success() {
            let why = String::from_utf8_lossy(&output.stderr);
            return Err(format!("{}: {}", place.model.display(), why.trim_end()).into());
        }
        let score: Value = serde_json::from_slice(&output.stdout)?;
        seen.psnr = score["psnr"].as_f64();
        seen.psnr_min = score["psnr_min"].as_f64();
        seen.said.extend(warnings(&output));
        let name = place.model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let picture = self.folder.join(format!("{name}.{view}.png"));
        let moved = std::fs::rename(pictures.join("worst-1.png"), &picture);
        moved.map_err(|error| format!("{}: cannot be written: {error}", picture.display()))?;
        seen.picture = Some(picture);
        std::fs::remove_dir_all(&pictures)?;
        Ok(())
    }

    /// Writes the photographs of a training, changed and damaged.
    fn write_photos(&self, training: &Training, folder: &Path) -> Result<(), Failure> {
        make_folder(folder)?;
        let mut photos: Dataset = self.scene.load(Split::Train, training.smaller)?;
        if let Some(change) = training.all {
            change.run(&mut photos.views, 0);
        }
        if let Some(change) = training.change {
            change.run(&mut photos.views, training.seed);
        }
        dataset::write(folder, Split::Train, &photos.views)?;
        if let Some(damage) = &training.damage {
            damage.run(&folder.join(Split::Train.name()))?;
        }
        Ok(())
    }

    /// This program, with the options that all runs have.
    fn program(&self, action: &str) -> Result<Command, Failure> {
        let mut command = crate::host::program()?;
        command.arg(action).args(["--json", "--quiet"]);
        if let Some(threads) = self.common.threads {
            command.args(["--threads", &threads.to_string()]);
        }
        let has_simd = match action {
            "info" => false,
            "train" => self.method.baseline().is_none(),
            _ => true,
        };
        if let Some(simd) = self.stress.vectors.simd.filter(|_| has_simd) {
            command.args(["--simd", simd.name()]);
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Ok(command)
    }

    fn run(&self, mut command: Command) -> Result<Output, Failure> {
        let child = command.spawn()?;
        self.stop.child(Some(&child));
        let output = child.wait_with_output();
        self.stop.child(None);
        let output = output?;
        self.stop.check()?;
        if was_interrupted(output.status) {
            return Err(Interrupted.into());
        }
        Ok(output)
    }
}

/// The warnings in what a command printed.
fn warnings(output: &Output) -> Vec<String> {
    let object: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let list = object["warnings"].as_array().into_iter().flatten();
    list.filter_map(Value::as_str).map(str::to_owned).collect()
}

fn read<T: serde::de::DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

fn write(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    Ok(output::write_atomic(path, &serde_json::to_vec_pretty(value)?)?)
}
