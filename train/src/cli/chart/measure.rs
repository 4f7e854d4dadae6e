//! From models to points: how good their pictures are, then how long they take.

use std::path::{Path, PathBuf};

use pocketnerf_core::Camera;
use serde::{Deserialize, Serialize};

use super::models::{Model, Models};
use super::progress::{Progress, duration};
use super::scenes::Scene;
use super::{Chart, Stop};
use crate::chart::rounds::{Contestant, rounds};
use crate::chart::statistics::Summary;
use crate::chart::{Axis, OURS, Point, frontier};
use crate::cli::train::quoted;
use crate::cli::{Common, Failure, make_folder, open_to_render};
use crate::dataset::{Dataset, hash_of};
use crate::evaluate::evaluate;
use crate::image_file;
use crate::lens::Lens;
use crate::metrics::Metrics;
use crate::output;
use crate::picture::{self, Sampling, Settings};

/// Pictures of points have at most so many pixels a side: what is larger is cropped.
const PICTURE: u32 = 400;
/// The difference is shown so many times brighter.
const GAIN: u8 = 4;
/// Views that are timed.
const TIMED: usize = 4;

/// What does not change from run to run: kept in a file, with what it is the score of.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Scored {
    of: String,
    views: usize,
    width: u32,
    height: u32,
    background: [f32; 3],
    psnr: Option<f64>,
    ssim: Option<f64>,
    ms_ssim: Option<f64>,
    lpips: Option<f64>,
    depth_error: Option<f64>,
    samples_per_ray: f64,
    seconds_per_frame: f64,
}

/// One way to render a model.
struct Way<'m> {
    model: &'m Model,
    factor: u32,
    settings: Settings,
    id: String,
}

/// Files of pictures, by their points' order.
pub(super) type Pictures = Vec<(String, PathBuf)>;

/// Scores everything, then times everything in rounds, so many.
pub(super) fn measure(
    chart: &Chart,
    scenes: &[Scene],
    models: &Models,
    metrics: &Metrics,
    common: &Common,
    stop: &Stop,
) -> Result<(Vec<Point>, Pictures, usize), Failure> {
    let folders =
        [make_folder(&chart.out.join("scores"))?, make_folder(&chart.out.join("pictures"))?];
    // A table for each model, which is its files' memory as long as anything is rendered.
    let mut tables = vec![Vec::new(); models.all.len()];
    let files: Vec<_> = models
        .all
        .iter()
        .zip(&mut tables)
        .map(|(model, table)| open_to_render(&model.path, &model.bytes, table))
        .collect::<Result<_, _>>()?;
    let n_ways =
        chart.qualities(common).len() * chart.sampling.len() * chart.downscale_factor.len();
    let mut progress = Progress::new("scoring", n_ways * files.len(), common.quiet);
    let (mut points, mut pictures, mut timed) = (Vec::new(), Vec::new(), Vec::new());
    for (i, scene) in scenes.iter().enumerate() {
        for &factor in &chart.downscale_factor {
            let mut dataset = scene.held_out(factor)?;
            let own: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
            let of_scene = models.all.iter().zip(&files).filter(|(model, _)| model.scene == i);
            for (model, file) in of_scene {
                // Poses are the dataset's.
                for (view, own) in dataset.views.iter_mut().zip(&own) {
                    view.camera = file.about.scene.camera_to_model(own);
                    crate::cli::eval::shift(&mut view.camera, file.about.pixel_origin);
                }
                let mut cameras: Vec<(Camera, Lens)> =
                    dataset.views.iter().map(|view| (view.camera, view.lens)).collect();
                let n = cameras.len();
                let mut number = 0..n;
                cameras.retain(|_| number.next().is_some_and(|i| i * TIMED % n < TIMED));
                for settings in chart.ways(common) {
                    stop.check()?;
                    let way = Way::new(scene, model, factor, settings);
                    let background = chart.background.unwrap_or(file.model.display.background);
                    let judge = Judge { dataset: &dataset, background, metrics, folders: &folders };
                    let (scored, picture) = judge.score(&way, &file.model)?;
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
            let (settings, expected) = (*settings, *expected);
            Contestant { model: &file.model, settings, cameras, expected }
        })
        .collect();
    let rounds = chart.rounds(contestants.iter().map(Contestant::turn).sum());
    time(&contestants, &mut points, rounds, common, stop)?;
    let on = frontier(&points, Axis::MsPerFrame, Axis::Psnr);
    points.iter_mut().zip(on).for_each(|(point, on)| point.frontier = on);
    Ok((points, pictures, rounds))
}

/// Times all in turns.
fn time(
    contestants: &[Contestant<'_>],
    points: &mut [Point],
    n_rounds: usize,
    common: &Common,
    stop: &Stop,
) -> Result<(), Failure> {
    let expected = n_rounds as f64 * contestants.iter().map(Contestant::turn).sum::<f64>();
    if !common.quiet {
        let n = contestants.len();
        eprintln!("timing {n} points in {n_rounds} rounds: about {}", duration(expected));
    }
    let mut progress = Progress::new("timing", n_rounds * contestants.len(), common.quiet);
    let mut interrupted = Ok(());
    let times = rounds(contestants, n_rounds, |turns| {
        progress.done(turns);
        interrupted = stop.check();
        interrupted.is_ok()
    })?;
    interrupted?;
    for (point, times) in points.iter_mut().zip(&times) {
        let Some(Summary { median, interval, spread }) = Summary::of(times) else { continue };
        let rays = f64::from(point.width) * f64::from(point.height);
        point.ms_per_frame = Some(median);
        [point.ms_low, point.ms_high] = interval.map(Some);
        point.spread = Some(spread);
        point.unsteady = Some(spread > Point::UNSTEADY);
        point.frames_per_second = Some(1e3 / median);
        point.rays_per_second = Some(rays * 1e3 / median);
        point.threads = Some(rayon::current_num_threads());
    }
    Ok(())
}

impl Chart {
    /// How each model is rendered.
    fn ways(&self, common: &Common) -> Vec<Settings> {
        let qualities = self.qualities(common);
        let with = |sampling: Sampling| {
            // The paper's sampling knows no quality.
            let n = if sampling == Sampling::Paper { 1 } else { qualities.len() };
            qualities[..n]
                .iter()
                .map(move |&quality| Settings { sampling, quality, ..common.picture(None) })
                .collect::<Vec<_>>()
        };
        self.sampling.iter().flat_map(|sampling| with(*sampling)).collect()
    }
}

/// What pictures are compared with, and where scores and pictures are kept.
struct Judge<'a> {
    dataset: &'a Dataset,
    background: [f32; 3],
    metrics: &'a Metrics,
    folders: &'a [PathBuf; 2],
}

impl Judge<'_> {
    /// The way's score and picture, those that are there or new ones.
    fn score(
        &self,
        way: &Way<'_>,
        model: &pocketnerf_core::Model<'_>,
    ) -> Result<(Scored, PathBuf), Failure> {
        let [scores, pictures] = self.folders;
        let path = scores.join(format!("{}.json", way.id));
        let picture = pictures.join(format!("{}.png", way.id));
        let of = self.identity(way);
        let kept = std::fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        if let Some(scored) = kept.filter(|scored: &Scored| scored.of == of && picture.is_file()) {
            return Ok((scored, picture));
        }
        let shown = self.dataset.views.len() / 2;
        let mut written = Ok(());
        let (dataset, background) = (self.dataset, self.background);
        let result =
            evaluate(model, dataset, background, &way.settings, self.metrics, |i, ours, truth| {
                if i == shown {
                    written = write_picture(&picture, &dataset.views[i].camera, ours, truth);
                }
            })?;
        written?;
        let known = |value: Option<f64>| value.filter(|value| value.is_finite());
        let scored = Scored {
            of,
            views: result.views,
            width: result.width,
            height: result.height,
            background: result.background,
            psnr: known(Some(result.psnr)),
            ssim: known(result.ssim),
            ms_ssim: known(result.ms_ssim),
            lpips: known(result.lpips),
            depth_error: known(result.depth_error),
            samples_per_ray: result.samples_per_ray,
            seconds_per_frame: result.seconds_per_frame,
        };
        output::write_atomic(&path, &serde_json::to_vec_pretty(&scored)?)?;
        Ok((scored, picture))
    }

    /// Everything that a score depends on.
    fn identity(&self, way: &Way<'_>) -> String {
        let Settings { simd, skip, quality, sampling, .. } = way.settings;
        format!(
            "model {:016x}, views {:016x}, on {:?}, {simd:?} {skip} {quality} {sampling:?}, LPIPS {:?}, {}",
            hash_of(&way.model.bytes),
            self.dataset.fingerprint(),
            self.background,
            self.metrics.lpips.as_ref().map(|lpips| lpips.network()),
            crate::chart::Program::this().commit.unwrap_or_default(),
        )
    }
}

/// Model, truth and difference side by side, of what is in the middle.
fn write_picture(
    path: &Path,
    camera: &Camera,
    ours: &[u8],
    truth: &[u8],
) -> Result<(), output::OutputError> {
    let [width, height] = [camera.width, camera.height].map(|side| side.min(PICTURE));
    let [left, top] = [(camera.width - width) / 2, (camera.height - height) / 2];
    let row = |y: u32| {
        3 * (y * camera.width + left) as usize..3 * (y * camera.width + left + width) as usize
    };
    let middle =
        |rgb: &[u8]| (top..top + height).flat_map(|y| rgb[row(y)].to_vec()).collect::<Vec<u8>>();
    let (ours, truth) = (middle(ours), middle(truth));
    let difference = image_file::difference(&ours, &truth, GAIN);
    let (width, pixels) = image_file::side_by_side(width, &[&ours, &truth, &difference]);
    image_file::write_rgb(path, width, height, &pixels)
}

impl<'m> Way<'m> {
    fn new(scene: &Scene, model: &'m Model, factor: u32, settings: Settings) -> Self {
        let mut parts = vec![scene.name.clone(), model.name.clone()];
        parts.extend(model.precision.map(str::to_owned));
        parts.push(match settings.sampling {
            Sampling::Occupancy => format!("q{}", settings.quality),
            Sampling::Paper => "paper".to_owned(),
        });
        if factor > 1 {
            parts.push(format!("x{factor}"));
        }
        Self { model, factor, settings, id: parts.join(".") }
    }

    /// The point, but for its times.
    fn point(
        &self,
        chart: &Chart,
        scene: &Scene,
        file: &pocketnerf_formats::ModelFile<'_>,
        scored: &Scored,
    ) -> Point {
        let Self { model, settings, .. } = self;
        let trained = model.trained.as_ref();
        let sampling = match settings.sampling {
            Sampling::Occupancy => "occupancy",
            Sampling::Paper => "paper",
        };
        let mut eval = format!(
            "pocketnerf eval {} {} --quality {}",
            quoted(&model.path),
            quoted(&scene.data),
            settings.quality
        );
        if settings.sampling == Sampling::Paper {
            eval += " --sampling paper";
        }
        if self.factor > 1 {
            eval += &format!(" --downscale-factor {}", self.factor);
        }
        eval += &scene.reading.given();
        Point {
            id: self.id.clone(),
            program: OURS.to_owned(),
            scene: scene.name.clone(),
            method: file.model.field.kind().to_owned(),
            model: model.name.clone(),
            precision: model.precision.map(str::to_owned),
            quality: Some(settings.quality),
            sampling: Some(sampling.to_owned()),
            split: chart.split.name().to_owned(),
            views: Some(scored.views),
            width: scored.width,
            height: scored.height,
            background: scored.background.map(|c| c.to_string()).join(","),
            seed: trained.map(|t| t.seed).or(file.about.provenance.map(|p| p.seed)),
            train_commit: trained.and_then(|t| t.commit.clone()),
            train_seconds: trained.map(|t| t.seconds),
            train_steps: trained.map(|t| t.steps).or(file.about.provenance.map(|p| p.steps)),
            train_memory_bytes: trained.and_then(|t| t.peak_memory_bytes),
            bytes: Some(model.bytes.len() as u64),
            psnr: scored.psnr,
            ssim: scored.ssim,
            ms_ssim: scored.ms_ssim,
            lpips: scored.lpips,
            depth_error: scored.depth_error,
            samples_per_ray: Some(scored.samples_per_ray),
            render_memory_bytes: Some(picture::memory_bytes(&file.model, settings)),
            train_command: model.command.clone(),
            eval_command: Some(eval),
            ..Point::default()
        }
    }
}

/// Seconds since 1970.
pub(super) fn now() -> u64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs())
}
