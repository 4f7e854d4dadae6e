//! From models to points: first their scores, then their times.

use std::path::PathBuf;

use pocketnerf_baselines::Baseline;
use pocketnerf_core::{Camera, SimdLevel};
use pocketnerf_formats::ModelFile;
use pocketnerf_train::dataset::{self, Dataset};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::{self, Antialias, Sampling, Settings};

use super::Chart;
use super::models::{Model, Models};
use super::scenes::Scene;
use super::score::{Judge, Scored};
use crate::chart::rounds::{Contestant, Subject, Turn, rounds};
use crate::chart::statistics::Summary;
use crate::chart::{Axis, OURS, Point, frontier};
use crate::commands::progress::{Progress, duration};
use crate::commands::stop::Stop;
use crate::commands::train::quoted;
use crate::commands::{Common, Failure, make_folder, open_to_render};
use crate::machine::Pace;

/// Views that are timed.
const TIMED: usize = 4;

/// One way to render a model.
pub(super) struct Way<'m> {
    pub(super) model: &'m Model,
    factor: u32,
    /// `None`: a baseline, of which there is one way.
    pub(super) settings: Option<Settings>,
    pub(super) id: String,
}

/// What was measured.
pub(super) struct Measured {
    pub(super) points: Vec<Point>,
    /// Files of pictures by their points' ids.
    pub(super) pictures: Vec<(String, PathBuf)>,
    pub(super) rounds: usize,
    /// Slowdown of the machine, compared with its best.
    pub(super) slowdown: f64,
}

/// Scores everything, then times everything in rounds.
pub(super) fn measure(
    chart: &Chart,
    scenes: &[Scene],
    models: &Models,
    metrics: &Metrics,
    common: &Common,
    stop: &Stop,
) -> Result<Measured, Failure> {
    let folders =
        [make_folder(&chart.out.join("scores"))?, make_folder(&chart.out.join("pictures"))?];
    // An empty-space skip table for each model, for as long as anything is rendered.
    let mut tables = vec![Vec::new(); models.all.len()];
    let files: Vec<_> = models
        .all
        .iter()
        .zip(&mut tables)
        .map(|(model, table)| File::open(model, table))
        .collect::<Result<_, _>>()?;
    let n_ways: usize = files.iter().map(|file| file.ways(chart).len()).sum();
    let mut progress = Progress::new("scoring", n_ways * chart.factors().len(), common);
    let (mut points, mut pictures, mut timed) = (Vec::new(), Vec::new(), Vec::new());
    for (i, scene) in scenes.iter().enumerate() {
        for &factor in chart.factors() {
            let mut dataset = scene.held_out(factor)?;
            let own: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
            let of_scene = models.all.iter().zip(&files).filter(|(model, _)| model.scene == i);
            for (model, file) in of_scene {
                for (view, own) in dataset.views.iter_mut().zip(&own) {
                    view.camera = *own;
                }
                file.place(&mut dataset);
                let mut cameras: Vec<(Camera, Lens)> =
                    dataset.views.iter().map(|view| (view.camera, view.lens)).collect();
                dataset::thin(&mut cameras, TIMED);
                for settings in file.ways(chart) {
                    stop.check()?;
                    let way = Way::new(scene, model, factor, settings);
                    let background = chart.background.unwrap_or_else(|| file.background());
                    let judge = Judge { dataset: &dataset, background, metrics, folders: &folders };
                    let (scored, picture) = judge.score(&way, file.subject(settings))?;
                    pictures.push((way.id.clone(), picture));
                    timed.push((file, settings, cameras.clone(), scored.seconds_per_frame));
                    points.push(way.point(chart, scene, file, &scored));
                    progress.done(points.len());
                }
            }
        }
    }
    drop(progress);
    let contestants: Vec<Contestant<'_>> = timed
        .iter()
        .map(|(file, settings, cameras, expected)| {
            let (subject, expected) = (file.subject(*settings), *expected);
            Contestant { subject, cameras, expected }
        })
        .collect();
    let rounds = chart.rounds(contestants.iter().map(Contestant::turn).sum());
    let slowdown = time(&contestants, &mut points, rounds, (chart.vectors.level(), common), stop)?;
    let on = frontier(&points, Axis::MsPerFrame, Axis::Psnr);
    points.iter_mut().zip(on).for_each(|(point, on)| point.frontier = on);
    Ok(Measured { points, pictures, rounds, slowdown })
}

/// Times all in turns, and returns the median slowdown of the machine.
fn time(
    contestants: &[Contestant<'_>],
    points: &mut [Point],
    n_rounds: usize,
    (simd, common): (SimdLevel, &Common),
    stop: &Stop,
) -> Result<f64, Failure> {
    let expected = n_rounds as f64 * contestants.iter().map(Contestant::turn).sum::<f64>();
    if !common.quiet {
        let n = contestants.len();
        eprintln!("timing {n} points in {n_rounds} rounds: about {}", duration(expected));
    }
    let mut progress = Progress::new("timing", n_rounds * contestants.len(), common);
    let mut interrupted = Ok(());
    let pace = Pace::new(simd)?;
    let turns = rounds(contestants, n_rounds, &pace, |turns| {
        progress.done(turns);
        interrupted = stop.check();
        interrupted.is_ok()
    })?;
    interrupted?;
    for (point, turns) in points.iter_mut().zip(&turns) {
        let of = |figure: fn(&Turn) -> f64| turns.iter().map(figure).collect::<Vec<f64>>();
        let clock = Summary::of(&of(|turn| turn.wall_ms));
        let Some(Summary { median, interval, spread }) = clock else {
            continue;
        };
        let rays = f64::from(point.width) * f64::from(point.height);
        point.ms_per_frame = Some(median);
        [point.ms_low, point.ms_high] = interval.map(Some);
        point.spread = Some(spread);
        point.unsteady = Some(spread > Point::UNSTEADY);
        let undisturbed = Summary::of(&of(Turn::normalized_ms));
        point.normalized_ms_per_frame = undisturbed.map(|summary| summary.median);
        point.frames_per_second = Some(1e3 / median);
        point.rays_per_second = Some(rays * 1e3 / median);
        point.threads = Some(rayon::current_num_threads());
    }
    let slowdowns: Vec<f64> = turns.iter().flatten().map(|turn| turn.slowdown).collect();
    Ok(Summary::of(&slowdowns).map_or(1.0, |slowdown| slowdown.median))
}

impl Chart {
    /// How each model is rendered.
    fn ways(&self) -> Vec<Settings> {
        let simd = self.vectors.level();
        let with = |sampling: Sampling| {
            // Quality changes nothing in hierarchical sampling.
            let n = if sampling == Sampling::Hierarchical { 1 } else { self.qualities.len() };
            let usual = Settings { simd, sampling, ..Settings::default() };
            self.qualities[..n].iter().map(move |&quality| Settings { quality, ..usual })
        };
        self.sampling.iter().flat_map(|&sampling| with(sampling.into())).collect()
    }
}

/// What a model's file holds.
enum File<'m> {
    Model(Box<ModelFile<'m>>),
    Baseline(&'m Baseline),
}

impl<'m> File<'m> {
    fn open(model: &'m Model, table: &'m mut Vec<u8>) -> Result<Self, Failure> {
        Ok(match &model.baseline {
            Some(baseline) => Self::Baseline(baseline),
            None => Self::Model(Box::new(open_to_render(&model.path, &model.bytes, table)?)),
        })
    }

    /// How it is rendered.
    fn ways(&self, chart: &Chart) -> Vec<Option<Settings>> {
        match self {
            // As `eval` renders where nothing else is asked for.
            Self::Model(file) => {
                let antialias = Antialias::of(&file.about);
                let ways = chart.ways().into_iter();
                ways.map(|way| Some(Settings { antialias, ..way })).collect()
            }
            Self::Baseline(_) => vec![None],
        }
    }

    /// What is rendered in one of these ways.
    fn subject(&self, settings: Option<Settings>) -> Subject<'_> {
        match self {
            Self::Model(file) => Subject::Model(&file.model, settings.unwrap_or_default()),
            Self::Baseline(baseline) => Subject::Baseline(baseline),
        }
    }

    /// Moves a dataset's cameras to where the model has them.
    fn place(&self, dataset: &mut Dataset) {
        let Self::Model(file) = self else { return };
        let own: Vec<Camera> = dataset
            .views
            .iter()
            .map(|view| dataset.camera_in_model(&view.camera, &file.about.scene))
            .collect();
        for (view, camera) in dataset.views.iter_mut().zip(own) {
            view.camera = camera;
            crate::commands::eval::shift(&mut view.camera, file.about.pixel_origin, 1);
        }
    }

    /// The colour behind its scene, sRGB.
    fn background(&self) -> [f32; 3] {
        match self {
            Self::Model(file) => file.model.display.srgb_background(),
            Self::Baseline(baseline) => baseline.background(),
        }
    }

    fn method(&self) -> &'static str {
        match self {
            Self::Model(file) => file.model.field.kind(),
            Self::Baseline(baseline) => baseline.method().name(),
        }
    }

    /// Seed and steps of its training.
    fn trained(&self) -> Option<(u64, u64)> {
        match self {
            Self::Model(file) => file.about.provenance.map(|p| (p.seed, p.steps)),
            Self::Baseline(baseline) => Some((baseline.origin().seed, baseline.steps().into())),
        }
    }
}

/// The word of a way to place samples.
const fn sampling_name(sampling: Sampling) -> &'static str {
    match sampling {
        Sampling::Occupancy => "occupancy",
        Sampling::Hierarchical => "hierarchical",
    }
}

impl<'m> Way<'m> {
    fn new(scene: &Scene, model: &'m Model, factor: u32, settings: Option<Settings>) -> Self {
        let mut parts = vec![scene.name.clone(), model.name.clone()];
        parts.extend(model.precision.map(str::to_owned));
        parts.extend(settings.map(|settings| match settings.sampling {
            Sampling::Occupancy => format!("q{}", settings.quality),
            Sampling::Hierarchical => sampling_name(settings.sampling).to_owned(),
        }));
        if factor > 1 {
            parts.push(format!("x{factor}"));
        }
        Self { model, factor, settings, id: parts.join(".") }
    }

    /// The point, but for its times.
    fn point(&self, chart: &Chart, scene: &Scene, file: &File<'_>, scored: &Scored) -> Point {
        let Self { model, settings, .. } = self;
        let trained = model.trained.as_ref();
        let (seed, steps) = file.trained().unzip();
        let mut eval = format!("pocketnerf eval {} {}", quoted(&model.path), quoted(&scene.data));
        if let Some(settings) = settings {
            eval += &format!(" --quality {}", settings.quality);
            if settings.sampling == Sampling::Hierarchical {
                eval += " --sampling hierarchical";
            }
        }
        if self.factor > 1 {
            eval += &format!(" --downscale-factor {}", self.factor);
        }
        eval += &scene.reading.given();
        Point {
            id: self.id.clone(),
            program: OURS.to_owned(),
            scene: scene.name.clone(),
            method: file.method().to_owned(),
            model: model.name.clone(),
            precision: model.precision.map(str::to_owned),
            quality: settings.map(|settings| settings.quality),
            sampling: settings.map(|settings| sampling_name(settings.sampling).to_owned()),
            split: chart.split.name().to_owned(),
            views: Some(scored.views),
            width: scored.width,
            height: scored.height,
            background: scored.background.map(|c| c.to_string()).join(","),
            seed: trained.map(|t| t.seed).or(seed),
            train_commit: trained.and_then(|t| t.commit.clone()),
            train_seconds: trained.map(|t| t.seconds),
            train_steps: trained.map(|t| t.steps).or(steps),
            train_memory_bytes: trained.and_then(|t| t.peak_memory_bytes),
            bytes: Some(model.file_length as u64),
            psnr: scored.psnr,
            psnr_median: scored.psnr_median,
            psnr_p05: scored.psnr_p05,
            psnr_min: scored.psnr_min,
            worst_view: scored.worst_view.clone(),
            ssim: scored.ssim,
            ms_ssim: scored.ms_ssim,
            lpips: scored.lpips,
            depth_error: scored.depth_error,
            samples_per_ray: settings.map(|_| scored.samples_per_ray),
            render_memory_bytes: match (file, settings) {
                (File::Model(file), Some(settings)) => {
                    Some(picture::memory_bytes(&file.model, settings))
                }
                _ => None,
            },
            train_command: model.command.clone(),
            eval_command: Some(eval),
            ..Point::default()
        }
    }
}
