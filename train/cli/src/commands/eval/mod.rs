//! `pocketnerf eval`.

mod baseline;
mod pictures;

use std::path::PathBuf;

use pocketnerf_baselines::is_baseline;
use pocketnerf_core::Camera;
use pocketnerf_formats::{ModelFile, PixelOrigin};
use pocketnerf_train::dataset::{Dataset, Split, poses};
use pocketnerf_train::evaluate::{Evaluation, PoseCorrection, evaluate_on};
use pocketnerf_train::metrics::{Lpips, Metrics, mean};
use pocketnerf_train::picture::Settings;

use super::antialias::{Antialiasing, size_doubt};
use super::device::{self, DeviceOption};
use super::parse::{parse_color, parse_pixel_origin};
use super::rendering::{Rendering, Sampling};
use super::{Common, Failure, Reading, open_to_render, print_line, read_model};
use pictures::Pictures;

#[derive(Debug, clap::Args)]
pub(super) struct Eval {
    /// Model file
    model: PathBuf,
    /// Dataset folder, or `builtin` or `builtin:NAME`: a built-in scene
    ///
    /// NAME: still-life (as without a name), wires, glossy, glass, foliage, fog, white, room or
    /// village.
    data: PathBuf,
    /// Folder for side-by-side pictures: rendering, image, difference
    ///
    /// 000.png and so on, in the order of the views; worst-1.png to worst-3.png are those with
    /// the lowest PSNR.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Views to compare: train, val or test
    #[arg(long, default_value = "test")]
    split: Split,
    /// Colour behind rendering and image: white, black or R,G,B [default: as the model file
    /// says]
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    background: Option<[f32; 3]>,
    /// Also measure LPIPS v0.1, with the weights in this .npz
    ///
    /// AlexNet or VGG16, backbone and heads in one file, such as numpy.savez writes of the
    /// state of the Python package lpips. This program comes without weights.
    #[arg(long, value_name = "FILE")]
    lpips_weights: Option<PathBuf>,
    /// Multiply each channel of a picture by a factor that is fitted on the left half of the image,
    /// and compare the right halves
    ///
    /// For captures whose photographs differ in exposure or white balance: those that are held out
    /// do too.
    #[arg(long)]
    fit_exposure: bool,
    /// Correct the pose of each photograph by what the model shows, before they are compared
    ///
    /// For models of `train --refine-poses`, and for photographs whose poses are less exact than the
    /// model: without it their errors count as the model's. Six numbers are fitted to each.
    #[arg(long)]
    fit_poses: bool,
    /// Compare with images downscaled by this factor
    #[arg(long, value_name = "K", default_value_t = 1, help_heading = "Dataset")]
    downscale_factor: u32,
    /// Where rays pass through pixels: center or corner [default: as the model file says]
    #[arg(long, value_name = "WHERE", value_parser = parse_pixel_origin, help_heading = "Dataset")]
    pixel_origin: Option<PixelOrigin>,
    #[command(flatten)]
    reading: Reading,
    /// Where the samples of a ray lie
    #[arg(long, value_enum, value_name = "HOW", default_value_t, help_heading = "Rendering")]
    sampling: Sampling,
    #[command(flatten)]
    antialiasing: Antialiasing,
    #[command(flatten)]
    device: DeviceOption,
    #[command(flatten)]
    rendering: Rendering,
}

impl Eval {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let lpips = self.lpips_weights.as_deref().map(Lpips::read).transpose()?;
        let Self { fit_exposure, fit_poses, .. } = *self;
        let metrics = Metrics { lpips, fit_exposure, fit_poses };
        let bytes = read_model(&self.model)?;
        if is_baseline(&bytes) {
            return self.compare_baseline(&bytes, &metrics, common);
        }
        let mut table = Vec::new();
        let file = open_to_render(&self.model, &bytes, &mut table)?;
        let mut dataset =
            self.reading.load(&self.data, self.split, self.downscale_factor, common)?;
        let mut warnings = dataset.notes.clone();
        let doubts = [self.other_scene(&file, &dataset), self.rendering.doubt()];
        for warning in doubts.into_iter().flatten() {
            common.warn(&warning);
            warnings.push(warning);
        }
        let antialias = self.antialiasing.of(&file.about);
        let first = dataset.views.first();
        let scene = &file.about.scene;
        let first = first.map(|view| dataset.camera_in_model(&view.camera, scene));
        let size = first.and_then(|camera| size_doubt(&file, &camera, antialias));
        if let Some(warning) = size {
            common.warn(&warning);
            warnings.push(warning);
        }
        let origin = self.pixel_origin.unwrap_or(file.about.pixel_origin);
        let mut views = std::mem::take(&mut dataset.views);
        for view in &mut views {
            view.camera = dataset.camera_in_model(&view.camera, scene);
            let n = antialias.rays(&view.camera);
            shift(&mut view.camera, origin, n);
        }
        dataset.views = views;
        let background = self.background.unwrap_or_else(|| file.model.display.srgb_background());
        let mut pictures = Pictures::new(self.out.as_deref())?;
        let views = &dataset.views;
        let settings = Settings {
            sampling: self.sampling.into(),
            antialias,
            ..self.rendering.settings(file.about.quality)
        };
        let (on, no_device) = self.device.open();
        let result =
            evaluate_on(&on, &file.model, &dataset, background, &settings, &metrics, |i, a, b| {
                pictures.add(i, &views[i].camera, a, b);
            })?;
        pictures.finish(&result.per_view)?;
        let fallback = result.fallback.as_deref();
        if let Some(warning) = no_device.or(fallback.map(device::on_cpu)) {
            common.warn(&warning);
            warnings.push(warning);
        }
        let method = file.model.field.kind();
        let device = device::name(&on, fallback);
        let stored = bytes.stored().len();
        self.report(&result, (stored, method, device), &metrics, &warnings, common)
    }

    /// Prints the scores of a file of so many bytes.
    fn report(
        &self,
        result: &Evaluation,
        (bytes, method, device): (usize, &str, &str),
        metrics: &Metrics,
        warnings: &[String],
        common: &Common,
    ) -> Result<(), Failure> {
        if common.json {
            let mut value = serde_json::to_value(result)?;
            value["model"] = self.model.display().to_string().into();
            value["bytes"] = bytes.into();
            value["method"] = method.into();
            value["split"] = self.split.name().into();
            value["fit_exposure"] = self.fit_exposure.into();
            value["fit_poses"] = self.fit_poses.into();
            value["device"] = device.into();
            value["warnings"] = warnings.into();
            value["lpips_network"] = metrics.lpips.as_ref().map(Lpips::network).into();
            common.result(value);
        } else {
            for view in &result.per_view {
                print_line(format_args!("{}: {:.2} dB", view.name, view.scores.psnr));
            }
            print_line(format_args!(
                "{} {} views, {}x{}, background {:?}: PSNR {:.2} dB \
                 (median {:.2}, 5th percentile {:.2}, worst {:.2}: {}){}, {:.3} s per frame, \
                 {:.1} samples per ray that hits something{}{}{}",
                result.views,
                self.split.name(),
                result.width,
                result.height,
                result.background,
                result.psnr,
                result.psnr_median,
                result.psnr_p05,
                result.psnr_min,
                result.worst_view.as_deref().unwrap_or("none"),
                others(result, metrics),
                result.seconds_per_frame,
                result.samples_per_hit_ray,
                match result.rays_per_pixel {
                    1 => String::new(),
                    n => format!(", {n} rays per pixel"),
                },
                match self.fit_exposure {
                    true => "; right halves, with exposure fitted on left halves",
                    false => "",
                },
                corrections(result).unwrap_or_default(),
            ));
        }
        Ok(())
    }
}

impl Eval {
    /// What to say of a model that was trained on a dataset of another name and, as far as can
    /// be told, on other views.
    fn other_scene(&self, file: &ModelFile<'_>, dataset: &Dataset) -> Option<String> {
        let origin = file.about.provenance.filter(|origin| origin.trained_on != 0)?;
        // A folder may have been renamed, and folders of other scenes may have the same name.
        let named_alike = origin.dataset == dataset.name() && self.has_camera_of(file);
        self.doubt_of_scene(named_alike, origin.dataset, origin.trained_on)
    }

    /// The same of one that is not known to be of this dataset, by its fingerprint.
    fn doubt_of_scene(&self, is_known: bool, name: &str, trained_on: u64) -> Option<String> {
        let train = || self.reading.read(&self.data, Split::Train, self.downscale_factor);
        let same = is_known || train().is_ok_and(|train| train.fingerprint() == trained_on);
        (!same).then(|| {
            format!(
                "{}: trained on {name:?}, expected a model of {}: the scores may be those of another \
                 scene",
                self.model.display(),
                self.data.display()
            )
        })
    }
}

impl Eval {
    /// Whether the dataset has the camera that the model starts with, its first training view's;
    /// yes where that is not known.
    fn has_camera_of(&self, file: &ModelFile<'_>) -> bool {
        let options = self.reading.options(self.downscale_factor);
        let (Some(camera), Ok(poses)) = (file.about.camera, poses(&self.data, &options)) else {
            return true;
        };
        poses.contains(&camera.camera_to_world)
    }
}

/// The other scores that there are.
fn others(result: &Evaluation, metrics: &Metrics) -> String {
    let network = metrics.lpips.as_ref().map_or("", Lpips::network);
    let named = [
        ("SSIM", result.ssim),
        ("MS-SSIM", result.ms_ssim),
        (&format!("LPIPS ({network})"), result.lpips),
    ];
    let known = named.iter().filter_map(|(name, score)| Some(format!(", {name} {:.4}", (*score)?)));
    let parts = [("far parts", result.psnr_far), ("near parts", result.psnr_near)];
    let parts =
        parts.iter().filter_map(|(what, psnr)| Some(format!(", {what} {:.2} dB", (*psnr)?)));
    known.chain(parts).collect()
}

/// How far poses were off, where they were fitted.
fn corrections(result: &Evaluation) -> Option<String> {
    let of = |figure: fn(&PoseCorrection) -> f64| {
        let found: Option<Vec<f64>> =
            result.per_view.iter().map(|view| view.pose_correction.as_ref().map(figure)).collect();
        let found = found?;
        Some([mean(found.iter().copied())?, found.into_iter().fold(0.0, f64::max)])
    };
    let [turn, most_turn] = of(|correction| correction.degrees)?;
    let [shift, most_shift] = of(|correction| correction.shift)?;
    Some(format!(
        "; poses fitted: turned by {turn:.3} degrees on average, {most_turn:.3} at most, and moved by \
         {shift:.4} scene units, {most_shift:.4} at most"
    ))
}

/// Moves the camera's rays, `n` along a side of a pixel, to where the model expects them in
/// the parts of the pixel that they stand for.
pub(super) fn shift(camera: &mut Camera, origin: PixelOrigin, n: u32) {
    if origin == PixelOrigin::Corner {
        camera.center = camera.center.map(|c| c + 0.5 / n as f32);
    }
}
