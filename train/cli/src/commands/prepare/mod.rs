//! `pocketnerf prepare`: photographs or a video to a dataset, by COLMAP and ffmpeg.

mod colmap;
mod photos;
mod source;
mod state;
mod video;

use std::path::PathBuf;

use pocketnerf_train::dataset::{self, LoadOptions};
use serde_json::json;

use super::progress::duration;
use super::stop::Stop;
use super::tool::{COLMAP, FFMPEG, FFPROBE, Runner, Tool};
use super::train::quoted;
use super::{Common, Failure, print_line};
use colmap::{Colmap, Matcher};
use source::Source;
use state::State;

/// Where COLMAP's models are in a dataset.
const MODELS: &str = "sparse";
/// A video's frames are matched with their neighbours alone from so many on; each with each takes
/// time that grows with the square.
const MANY: usize = 150;
/// Share of the photographs that should be registered.
const MOST: f64 = 0.9;

#[derive(Debug, clap::Args)]
pub(super) struct Prepare {
    /// Folder of photographs (PNG, JPEG), or a video
    source: PathBuf,
    /// Folder of the dataset: a new one, or one that the same command has begun
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Frames to take of a video, evenly spread, the sharpest of three each
    #[arg(long, value_name = "N", default_value_t = 100,
        value_parser = clap::value_parser!(u32).range(2..=10_000))]
    frames: u32,
    /// Which photographs are compared [default: exhaustive; sequential for 150 frames or more of a
    /// video]
    #[arg(long, value_enum, value_name = "KIND")]
    matcher: Option<Matcher>,
    /// Features of a photograph at most; twice as many take four times as long to match, and may
    /// help where photographs are not registered
    #[arg(long, value_name = "N", default_value_t = 2048,
        value_parser = clap::value_parser!(u32).range(100..=65_536))]
    features: u32,
    /// Link photographs instead of copying them (hard links: one file, two names)
    #[arg(long)]
    link: bool,
}

/// A stage of the work.
struct Stage {
    name: &'static str,
    seconds: f64,
    /// Whether an earlier run had done it.
    was_done: bool,
}

impl Prepare {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let stop = Stop::listen(common, "interrupted before anything was done")?;
        let source = Source::at(&self.source)?;
        // Before any work: what is missing.
        for tool in self.tools(&source) {
            tool.ask(&["-version"])?;
        }
        let of = match &source {
            Source::Photos { .. } => String::new(),
            Source::Video(_) => format!("{} frames, ", self.frames),
        };
        let how = format!("{of}{} features, {:?}", self.features, self.matcher);
        let of = format!("{}, {how}", source.identity());
        let mut state = State::open(&self.out, of)?;
        // From here on what is done stays.
        stop.defer();
        let runner = Runner { log: self.out.join("prepare.log"), stop: &stop };
        let mut stages = Vec::new();
        self.work(&source, &mut state, &runner, common, &mut stages)?;
        self.report(&source, &stages, common)
    }

    fn tools(&self, source: &Source) -> Vec<Tool> {
        match source {
            Source::Photos { .. } => vec![COLMAP],
            Source::Video(_) => vec![FFMPEG, FFPROBE, COLMAP],
        }
    }

    fn work(
        &self,
        source: &Source,
        state: &mut State,
        runner: &Runner<'_>,
        common: &Common,
        stages: &mut Vec<Stage>,
    ) -> Result<(), Failure> {
        let images = self.out.join("images");
        let mut stage = |name: &'static str, work: &dyn Fn() -> Result<(), Failure>| {
            runner.stop.check()?;
            let began = std::time::Instant::now();
            let has_worked = state.stage(name, work)?;
            let seconds = began.elapsed().as_secs_f64();
            if !common.quiet {
                let how = match has_worked {
                    true => duration(seconds),
                    false => "done before".to_owned(),
                };
                eprintln!("{name}: {how}");
            }
            stages.push(Stage { name, seconds, was_done: !has_worked });
            Ok::<(), Failure>(())
        };
        stage("images", &|| match source {
            Source::Photos { folder, names } => {
                photos::bring((folder, names), &images, self.link, common, runner.stop)
            }
            Source::Video(file) => photos::fill(&images, |part| {
                video::frames(file, self.frames as usize, part, runner, common)
            }),
        })?;
        let names = dataset::photographs(&images)?;
        let colmap = Colmap {
            images: &images,
            database: &self.out.join("colmap.db"),
            n_images: names.len(),
            features: self.features,
            threads: common.threads,
            common,
            runner,
        };
        let is_long = matches!(source, Source::Video(_)) && names.len() >= MANY;
        let usual = if is_long { Matcher::Sequential } else { Matcher::Exhaustive };
        stage("features", &|| colmap.features(dataset::are_of_one_size(&images, &names)))?;
        stage("matches", &|| colmap.matches(self.matcher.unwrap_or(usual)))?;
        stage("cameras", &|| {
            photos::fill(&self.out.join(MODELS), |part| {
                colmap.model(part)?;
                match std::fs::read_dir(part)?.next() {
                    Some(_) => Ok(()),
                    None => Err(format!(
                        "{}: COLMAP has found no cameras: photographs overlap too little, or show \
                         too little that is told apart; take more, from nearer to each other (what \
                         it said is in {})",
                        self.source.display(),
                        runner.log.display()
                    )
                    .into()),
                }
            })
        })
    }

    /// Says what came of it.
    fn report(&self, source: &Source, stages: &[Stage], common: &Common) -> Result<(), Failure> {
        let all = dataset::photographs(&self.out.join("images"))?.len();
        let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
        let registered = dataset::poses(&self.out, &options)?.len();
        let models = std::fs::read_dir(self.out.join(MODELS))?.count();
        let mut warnings = Vec::new();
        if (registered as f64) < MOST * all as f64 {
            warnings.push(format!(
                "only {registered} of {all} photographs are registered, expected nearly all: the \
                 others are not used; take more that overlap with these, or try --features 8192"
            ));
        }
        let out = self.out.display();
        // Of what an earlier run did, nobody knows how.
        let is_new = stages.first().is_some_and(|images| !images.was_done);
        let brought = is_new.then_some(match (source, self.link) {
            (Source::Video(_), _) => "taken",
            (_, true) => "linked",
            (_, false) => "copied",
        });
        let of = match models {
            1 => String::new(),
            n => format!(", in the largest of {n} models"),
        };
        if common.json {
            let stages: Vec<_> = stages
                .iter()
                .map(|Stage { name, seconds, was_done }| {
                    json!({"name": name, "seconds": seconds, "was_done": was_done})
                })
                .collect();
            let object = json!({
                "out": self.out,
                "photographs": all,
                "brought": brought,
                "registered": registered,
                "models": models,
                "stages": stages,
                "seconds": common.started.elapsed().as_secs_f64(),
            });
            common.print_json(object, &warnings);
        } else {
            warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
            let brought = brought.map_or_else(String::new, |how| format!(" {how}"));
            print_line(format_args!(
                "{out}: {all} photographs{brought}, {registered} registered{of}; next: pocketnerf \
                 train {} --out {}",
                quoted(&self.out),
                quoted(&self.model())
            ));
        }
        Ok(())
    }

    /// A model beside the dataset.
    fn model(&self) -> PathBuf {
        let mut name = self.out.components().as_path().as_os_str().to_owned();
        name.push(".pnerf");
        name.into()
    }
}
