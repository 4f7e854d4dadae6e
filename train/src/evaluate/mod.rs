//! A model against the views of a dataset.

mod least_squares;
mod pose_fit;

use std::time::Instant;

use pocketnerf_core::render::RenderStats;
use pocketnerf_core::{Camera, Display, Error, Model};
use serde::Serialize;

use crate::cameras::distances;
use crate::dataset::Dataset;
use crate::metrics::{
    Metrics, Scores, composite_on, depth_error, exposure, psnr_far_near, quantile, quantize_all,
};
use crate::picture::{self, Antialias, Device, Painter, Renderer};
pub use pose_fit::PoseCorrection;
use pose_fit::fit_pose;

/// What lies farther away than this many times the mean distance of the cameras from what they
/// look at is far.
const FAR: f32 = 3.0;

/// One view's result.
#[derive(Clone, Debug, Serialize)]
pub struct ViewScore {
    /// The view's name.
    pub name: String,
    /// By what each channel of the picture was multiplied before its right half was compared:
    /// [`Metrics::fit_exposure`]; `null` where that is not asked for, or nothing there counts.
    pub exposure: Option<[f32; 3]>,
    /// By how much its pose was corrected before: [`Metrics::fit_poses`]; `null` where that is not
    /// asked for.
    pub pose_correction: Option<PoseCorrection>,
    /// How close its picture is.
    #[serde(flatten)]
    pub scores: Scores,
    /// Mean absolute difference of depths, scene units; `null` where the truth is not known,
    /// and where nothing is seen that is there.
    pub depth_error: Option<f64>,
    /// Share of pixels where something is rendered and nothing is there, or the other way
    /// round; `null` where the truth is not known.
    pub depth_missed: Option<f64>,
    /// PSNR of what is far away, see [`Evaluation::psnr_far`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_far: Option<f64>,
    /// PSNR of the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_near: Option<f64>,
}

/// Results over a split.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Number of views.
    pub views: usize,
    /// Picture width of the first view.
    pub width: u32,
    /// Picture height of the first view.
    pub height: u32,
    /// What the pictures and the truth were composited on, sRGB.
    pub background: [f32; 3],
    /// Mean of the views' PSNR, dB.
    pub psnr: f64,
    /// Median of the views' PSNR.
    pub psnr_median: f64,
    /// Their 5th percentile, interpolated between two views.
    pub psnr_p05: f64,
    /// The worst view's PSNR: a model may be good on average and fail from some directions.
    pub psnr_min: f64,
    /// The name of that view, the first of several; `null` without views.
    pub worst_view: Option<String>,
    /// Mean of the views' SSIM; here and below, `null` where a view has none.
    pub ssim: Option<f64>,
    /// Mean of the views' MS-SSIM.
    pub ms_ssim: Option<f64>,
    /// Mean of the views' LPIPS; `null` without its weights.
    pub lpips: Option<f64>,
    /// Mean of the views' depth errors, scene units, over the views that have one.
    pub depth_error: Option<f64>,
    /// Mean of the views' shares of missed pixels, over the views that have one.
    pub depth_missed: Option<f64>,
    /// Mean over views of the PSNR of those pixels whose true depth is more than three times
    /// the mean distance of the cameras from what they look at, the sky's among them. Only of
    /// opaque images whose true depths are known; left out of JSON otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_far: Option<f64>,
    /// The same of all other pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_near: Option<f64>,
    /// Every view.
    pub per_view: Vec<ViewScore>,
    /// Median rendering time.
    pub seconds_per_frame: f64,
    /// Its inverse.
    pub frames_per_second: f64,
    /// Rays that a pixel of the first view has: n × n, see [`picture::Antialias`].
    pub rays_per_pixel: u32,
    /// Rays a second, interpolated ones too.
    pub rays_per_second: f64,
    /// Samples at which the field was asked, a ray, interpolated ones too.
    pub samples_per_ray: f64,
    /// The same, a ray along which the field was asked at all.
    pub samples_per_hit_ray: f64,
    /// Threads that rendered.
    pub threads: usize,
    /// Why the CPU has rendered what another device was to.
    #[serde(skip)]
    pub fallback: Option<String>,
}

/// Renders every view over an sRGB `background` and compares by `metrics`; `each` receives
/// the view's number, its 8-bit picture and the 8-bit truth.
///
/// What a view's mask ignores does not count: see [`Metrics::compare`]. Where the true depths
/// are known, they are compared with those of a second picture, which no time is taken of: one
/// ray a pixel, as the true depths have.
///
/// # Errors
/// Whatever rendering reports.
pub fn evaluate(
    model: &Model<'_>,
    dataset: &Dataset,
    background: [f32; 3],
    settings: &picture::Settings,
    metrics: &Metrics,
    each: impl FnMut(usize, &[u8], &[u8]),
) -> Result<Evaluation, Error> {
    evaluate_on(&Device::Cpu, model, dataset, background, settings, metrics, each)
}

/// As [`evaluate`], with pictures that are rendered on `device`.
///
/// # Errors
/// Whatever rendering reports.
pub fn evaluate_on(
    device: &Device,
    model: &Model<'_>,
    dataset: &Dataset,
    background: [f32; 3],
    settings: &picture::Settings,
    metrics: &Metrics,
    each: impl FnMut(usize, &[u8], &[u8]),
) -> Result<Evaluation, Error> {
    let mut renderer = Renderer::on(device, model, settings);
    let antialias = settings.antialias;
    let deep = picture::Settings { depth: true, antialias: Antialias::Off, ..*settings };
    // What is interpolated changes by jumps, which slopes cannot be taken of.
    let exact = picture::Settings { quality: 1.0, ..deep };
    let mut exact = metrics.fit_poses.then(|| Renderer::new(model, &exact));
    let mut deep = Renderer::new(model, &deep);
    let behind = model.display.color_space.from_srgb(background);
    let display = Display { background: behind, ..model.display };
    let judge = Judge { dataset, background, display, antialias, metrics };
    let exact = exact.as_mut().map(|exact| exact as &mut dyn Painter);
    let found = judge.score(&mut renderer, Some(&mut deep), exact, each)?;
    Ok(Evaluation { fallback: renderer.fallback().map(str::to_owned), ..found })
}

/// As [`evaluate`], of the sRGB pictures of any `painter`. Depths are not compared, and samples are
/// those that its pictures say.
///
/// # Errors
/// Whatever rendering reports.
pub fn evaluate_pictures(
    painter: &mut dyn Painter,
    dataset: &Dataset,
    background: [f32; 3],
    metrics: &Metrics,
    each: impl FnMut(usize, &[u8], &[u8]),
) -> Result<Evaluation, Error> {
    let display = Display { background, ..Display::default() };
    let judge = Judge { dataset, background, display, antialias: Antialias::Off, metrics };
    judge.score(painter, None, None, each)
}

/// What pictures are compared with, and how.
struct Judge<'a> {
    dataset: &'a Dataset,
    /// Behind the truth, sRGB.
    background: [f32; 3],
    display: Display,
    antialias: Antialias,
    metrics: &'a Metrics,
}

impl Judge<'_> {
    /// Scores a painter's pictures, and the depths that another one renders. Poses are fitted with a
    /// third one, or else with the first.
    fn score(
        &self,
        painter: &mut dyn Painter,
        mut deep: Option<&mut dyn Painter>,
        mut exact: Option<&mut dyn Painter>,
        mut each: impl FnMut(usize, &[u8], &[u8]),
    ) -> Result<Evaluation, Error> {
        let Self { dataset, background, display, antialias, metrics } = *self;
        let (mut times, mut per_view, mut rays) = (Vec::new(), Vec::new(), 0);
        let mut stats = RenderStats::default();
        let rays_of = |camera: &Camera| u64::from(antialias.rays(camera)).pow(2);
        let (limit, ahead) = (far_from(dataset), mean_distance(dataset));
        for (i, view) in dataset.views.iter().enumerate() {
            let (mut camera, mut pose_correction) = (view.camera, None);
            if metrics.fit_poses {
                let fitted = match &mut exact {
                    Some(exact) => fit_pose(*exact, view, &display, ahead)?,
                    None => fit_pose(painter, view, &display, ahead)?,
                };
                (camera, pose_correction) = (fitted.0, Some(fitted.1));
            }
            let begun = Instant::now();
            let rendered = painter.paint(&camera, &view.lens)?;
            times.push(begun.elapsed().as_secs_f64());
            let pixels = u64::from(rendered.width) * u64::from(rendered.height);
            rays += rays_of(&view.camera) * pixels;
            stats += rendered.stats;
            let half = metrics.fit_exposure.then(|| exposure::right_half(view)).flatten();
            let space = display.color_space;
            let (fitted_exposure, picture) = match half.is_some() {
                true => {
                    let mut rendered = rendered.clone();
                    let factors = exposure::fit(&mut rendered, view, space);
                    (Some(factors), rendered.rgb8(&display))
                }
                false => (None, rendered.rgb8(&display)),
            };
            let truth = quantize_all(&composite_on(&view.rgba, background));
            let (mask, size) = (view.mask.as_deref(), [view.camera.width, view.camera.height]);
            let compared = half.as_deref().or(mask);
            let scores =
                metrics.compare(&picture, &truth, compared, size.map(|side| side as usize));
            let depth = match (&view.depth, &mut deep) {
                (Some(truth), Some(deep)) => {
                    let rendered = deep.paint(&camera, &view.lens)?;
                    depth_error(&rendered.depth, truth, mask)
                }
                _ => None,
            };
            let [psnr_far, psnr_near] = match (&view.depth, limit) {
                (Some(depth), Some(limit)) => psnr_far_near(&picture, &truth, depth, limit, mask),
                _ => [None; 2],
            };
            per_view.push(ViewScore {
                name: view.name.clone(),
                exposure: fitted_exposure,
                pose_correction,
                scores,
                depth_error: depth.and_then(|depth| depth.mean),
                depth_missed: depth.map(|depth| depth.missed),
                psnr_far,
                psnr_near,
            });
            each(i, &picture, &truth);
        }
        let n = per_view.len().max(1) as f64;
        let total: f64 = times.iter().sum();
        times.sort_by(f64::total_cmp);
        let median = times.get(times.len() / 2).copied().unwrap_or(0.0);
        let of_all = |score: fn(&Scores) -> Option<f64>| {
            Some(per_view.iter().map(|view| score(&view.scores)).sum::<Option<f64>>()? / n)
        };
        let ascending = worst(&per_view);
        let psnr: Vec<f64> = ascending.iter().map(|view| per_view[*view].scores.psnr).collect();
        let psnr_at = |q| quantile(&psnr, q).unwrap_or(0.0);
        let first = dataset.views.first().map_or([0, 0], |v| [v.camera.width, v.camera.height]);
        Ok(Evaluation {
            views: per_view.len(),
            width: first[0],
            height: first[1],
            background,
            psnr: per_view.iter().map(|view| view.scores.psnr).sum::<f64>() / n,
            psnr_median: psnr_at(0.5),
            psnr_p05: psnr_at(0.05),
            psnr_min: psnr_at(0.0),
            worst_view: ascending.first().map(|view| per_view[*view].name.clone()),
            ssim: of_all(|scores| scores.ssim),
            ms_ssim: of_all(|scores| scores.ms_ssim),
            lpips: of_all(|scores| scores.lpips),
            depth_error: mean_of_known(per_view.iter().filter_map(|view| view.depth_error)),
            depth_missed: mean_of_known(per_view.iter().filter_map(|view| view.depth_missed)),
            psnr_far: mean_of_known(per_view.iter().filter_map(|view| view.psnr_far)),
            psnr_near: mean_of_known(per_view.iter().filter_map(|view| view.psnr_near)),
            per_view,
            seconds_per_frame: median,
            frames_per_second: 1.0 / median.max(1e-9),
            rays_per_pixel: dataset.views.first().map_or(1, |view| rays_of(&view.camera) as u32),
            rays_per_second: rays as f64 / total.max(1e-9),
            samples_per_ray: stats.samples as f64 / (rays as f64).max(1.0),
            samples_per_hit_ray: stats.samples as f64 / (stats.hits as f64).max(1.0),
            threads: rayon::current_num_threads(),
            fallback: None,
        })
    }
}

/// The views' indices in ascending order of PSNR.
#[must_use]
pub fn worst(per_view: &[ViewScore]) -> Vec<usize> {
    let mut views: Vec<usize> = (0..per_view.len()).collect();
    views.sort_by(|a, b| per_view[*a].scores.psnr.total_cmp(&per_view[*b].scores.psnr));
    views
}

/// The depth beyond which opaque images show what is far away.
fn far_from(dataset: &Dataset) -> Option<f32> {
    (!dataset.has_alpha).then_some(FAR * mean_distance(dataset))
}

/// The mean distance of the cameras from what they look at.
fn mean_distance(dataset: &Dataset) -> f32 {
    let cameras: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
    let (_, distances) = distances(&cameras);
    distances.iter().sum::<f32>() / distances.len().max(1) as f32
}

/// The mean of what there is.
fn mean_of_known(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (n, sum) = values.fold((0_u32, 0.0), |(n, sum), value| (n + 1, sum + value));
    (n > 0).then(|| sum / f64::from(n))
}
