//! `pocketnerf render`.

mod baseline;
mod geometry;
mod outputs;
mod path;
mod target;
mod unfinished;
mod video;

use std::hash::Hash;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use pocketnerf_baselines::is_baseline;
use pocketnerf_core::{Camera, Display, Model};
use pocketnerf_train::picture::{self, Antialias, Device, Picture, Progressive};
use serde_json::{Value, json};

use super::antialias::{Antialiasing, size_doubt};
use super::device::{self, DeviceOption};
use super::parse::parse_color;
use super::progress::Progress;
use super::rendering::{Rendering, Sampling};
use super::stop::Stop;
use super::{Common, Failure, memory, open_to_render, read_model};
use geometry::{Geometry, Numbers};
use outputs::Outputs;
use path::Place;
use target::Kind;

/// Pictures of a video a second, unless something else is asked for.
const FPS: f32 = 30.0;

#[derive(Debug, clap::Args)]
pub(super) struct Render {
    /// Model file
    model: PathBuf,
    /// Picture (.png, .jpg), video (.mp4, .webm, .gif), or folder for several pictures [default:
    /// render.png]
    ///
    /// A path that was interrupted goes on where it was if the same command is given again. Videos
    /// need ffmpeg.
    #[arg(long, value_name = "FILE|DIR")]
    out: Option<PathBuf>,
    /// Video of the pictures (.mp4, .webm, .gif), beside --out or instead of it
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// Pictures of a video per second [default: as the camera path says, else 30]
    #[arg(long, value_name = "N", value_parser = parse_fps)]
    fps: Option<f32>,
    #[command(flatten)]
    path: path::Path,
    /// Colour behind the scene: white, black or R,G,B [default: as the model file says]
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    background: Option<[f32; 3]>,
    #[command(flatten)]
    geometry: Geometry,
    /// Render coarse pictures first, and refine them for at most T milliseconds each
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..))]
    deadline_ms: Option<u32>,
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

impl Render {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let stop = Stop::listen(common, "interrupted before the first picture")?;
        let bytes = read_model(&self.model)?;
        if is_baseline(&bytes) {
            return self.render_baseline(&bytes, &stop, common);
        }
        let mut table = Vec::new();
        let file = open_to_render(&self.model, &bytes, &mut table)?;
        let place = Place { about: &file.about, space: &file.model.space };
        let (cameras, fps) = self.cameras(place)?;
        let own = &file.model.display;
        let background = self.background.map(|color| own.color_space.from_srgb(color));
        let display = Display { background: background.unwrap_or(own.background), ..*own };
        let (depth, sampling) = (self.geometry.depth.is_some(), self.sampling.into());
        let antialias = self.antialiasing.of(&file.about);
        let usual = self.rendering.settings(file.about.quality);
        let settings = picture::Settings { depth, sampling, antialias, ..usual };
        // With a deadline, all rays are kept until the end.
        let kept = if self.deadline_ms.is_some() { antialias } else { Antialias::Off };
        let numbers = self.geometry.bytes_a_pixel();
        memory::check(picture_bytes(&cameras, kept, numbers), "render smaller pictures", || {
            "a picture".to_owned()
        })?;
        let first = cameras.first();
        let doubt = first.and_then(|camera| size_doubt(&file, camera, antialias));
        let mut warnings = Vec::new();
        let mut warn = |warning: Option<String>| {
            if let (Some(warning), false) = (&warning, common.quiet) {
                common.warn(warning);
            }
            warnings.extend(warning);
        };
        warn(doubt);
        let (on, no_device) = self.device.open();
        warn(no_device);
        let how = (self.deadline_ms, &self.device, device::name(&on, None), self.geometry);
        let work = format!("{cameras:?} {display:?} {settings:?} {how:?}");
        let work = (bytes.stored(), work, env!("CARGO_PKG_VERSION"));
        let mut renderer = picture::Renderer::on(&on, &file.model, &settings);
        let mut refined = Picture::default();
        let seconds = self.pictures((&cameras, fps), &work, &stop, common, |camera| {
            let rendered = match self.deadline_ms {
                None => renderer.render(camera)?,
                Some(ms) => {
                    let within = Duration::from_millis(ms.into());
                    refined = in_time(&file.model, camera, &settings, within, common)?;
                    &refined
                }
            };
            let numbers = self.geometry.of((&file, &settings), camera, rendered)?;
            Ok((rendered.rgb8(&display), numbers))
        })?;
        let refined = self.deadline_ms.map(|_| "--deadline-ms is for the CPU");
        let fallback = renderer.fallback().or(refined);
        let device = device::name(&on, fallback);
        if !matches!(on, Device::Cpu) {
            warn(fallback.map(device::on_cpu));
        }
        let object = json!({
            "bytes": bytes.stored().len(),
            "method": file.model.field.kind(),
            "rays_per_pixel": first.map(|camera| antialias.rays(camera).pow(2)),
            "device": device,
        });
        self.report(&cameras, seconds, object, &warnings, common);
        Ok(())
    }

    /// Takes all pictures that are not there yet, as 8-bit sRGB and the numbers beside it, and gives
    /// the seconds of one.
    fn pictures(
        &self,
        (cameras, fps): (&[Camera], f32),
        work: &impl Hash,
        stop: &Stop,
        common: &Common,
        mut take: impl FnMut(&Camera) -> Result<(Vec<u8>, Numbers), Failure>,
    ) -> Result<f64, Failure> {
        let mut outputs = self.outputs((cameras, fps), work)?;
        let begun = outputs.done();
        if begun > 0 {
            common.say(&format!("{begun} of {} pictures are there already", cameras.len()));
        }
        let quiet = Common { quiet: common.quiet || cameras.len() == 1, ..common.clone() };
        let mut progress = Progress::new("pictures", cameras.len(), &quiet);
        let mut seconds = 0.0;
        stop.defer();
        for (i, camera) in cameras.iter().enumerate().skip(begun) {
            if stop.is_asked() {
                outputs.interrupt(i);
                stop.check()?;
            }
            let begun = Instant::now();
            let (rgb, numbers) = take(camera)?;
            seconds += begun.elapsed().as_secs_f64();
            outputs.add((i, camera), &rgb, &numbers)?;
            progress.done(i + 1);
        }
        outputs.finish()?;
        Ok(seconds / (cameras.len() - begun).max(1) as f64)
    }

    /// Prints what was rendered. `object` has what differs between models and baselines.
    fn report(
        &self,
        cameras: &[Camera],
        seconds_per_frame: f64,
        mut object: Value,
        warnings: &[String],
        common: &Common,
    ) {
        let n = cameras.len();
        if common.json {
            let first = cameras.first();
            object["model"] = self.model.display().to_string().into();
            object["pictures"] = n.into();
            object["width"] = first.map(|camera| camera.width).into();
            object["height"] = first.map(|camera| camera.height).into();
            object["seconds_per_frame"] = seconds_per_frame.into();
            object["seconds"] = common.started.elapsed().as_secs_f64().into();
            object["threads"] = rayon::current_num_threads().into();
            object["out"] = self.out().map(|out| out.display().to_string()).into();
            object["video"] = self.video.as_ref().map(|video| video.display().to_string()).into();
            common.print_json(object, warnings);
        } else if !common.quiet {
            let pictures = if n == 1 { "picture" } else { "pictures" };
            for out in self.out().iter().chain(&self.video) {
                common.say(&format!("{}: {n} {pictures}", out.display()));
            }
        }
    }

    /// The cameras, in the model's coordinates, and pictures a second.
    fn cameras(&self, place: Place<'_>) -> Result<(Vec<Camera>, f32), Failure> {
        let path = self.path.cameras(place, (self.asks_for_a_video(), self.fps))?;
        Ok((path.cameras, path.fps.map_or(FPS, |fps| (fps as f32).clamp(0.1, 240.0))))
    }

    /// Where pictures go, unless a video is all that is asked for.
    fn out(&self) -> Option<PathBuf> {
        let usual = || self.video.is_none().then(|| PathBuf::from("render.png"));
        self.out.clone().or_else(usual)
    }

    fn asks_for_a_video(&self) -> bool {
        let is_video = |path: &PathBuf| Kind::of(path).is_some();
        self.video.is_some() || self.out.as_ref().is_some_and(is_video)
    }

    fn outputs(
        &self,
        (cameras, fps): (&[Camera], f32),
        work: &impl Hash,
    ) -> Result<Outputs, Failure> {
        let mut outputs = Outputs::new(self.geometry);
        let is_video = || self.out().is_none_or(|out| Kind::of(&out).is_some());
        if let Some(option) = self.geometry.option().filter(|_| is_video()) {
            return Err(format!("{option}: a video has none; give a folder with --out too").into());
        }
        if let Some(path) = &self.video {
            if Kind::of(path).is_none() {
                let name = path.display();
                return Err(format!("{name}: expected a video: .mp4, .webm or .gif").into());
            }
            outputs.open(path, cameras, fps, work)?;
        }
        if let Some(path) = self.out() {
            if Some(&path) == self.video.as_ref() {
                let name = path.display();
                return Err(format!("{name}: --out and --video, expected a name each").into());
            }
            outputs.open(&path, cameras, fps, work)?;
        }
        Ok(outputs)
    }
}

fn parse_fps(text: &str) -> Result<f32, String> {
    let fps = text.parse().ok().filter(|fps| (0.1..=240.0).contains(fps));
    fps.ok_or_else(|| "expected a number from 0.1 to 240".to_owned())
}

/// Memory of the largest picture: colours and depths of its rays that are kept, the bytes that
/// are written, and so many for the numbers of a pixel.
fn picture_bytes(cameras: &[Camera], kept: Antialias, numbers: u64) -> u64 {
    let pixels = |camera: &Camera| u64::from(camera.width) * u64::from(camera.height);
    let bytes =
        |camera: &Camera| 32 * pixels(&camera.finer(kept.rays(camera))) + numbers * pixels(camera);
    cameras.iter().map(bytes).max().unwrap_or(0)
}

/// The finest picture that a deadline allows.
fn in_time(
    model: &Model<'_>,
    camera: &Camera,
    settings: &picture::Settings,
    within: Duration,
    common: &Common,
) -> Result<Picture, Failure> {
    let begun = Instant::now();
    let mut progressive = Progressive::new(model, camera, settings);
    progressive.refine(begun + within)?;
    let picture = progressive.picture();
    if !common.quiet {
        let share = |spacing| 100.0 * progressive.share(spacing);
        let rays = if settings.antialias.rays(camera) > 1 { "ray" } else { "pixel" };
        common.say(&format!(
            "{:.1} ms: every {rays} in {:.0} % of the picture, every 2nd in {:.0} %, every 4th in {:.0} %",
            1e3 * begun.elapsed().as_secs_f64(),
            share(1),
            share(2),
            share(4),
        ));
    }
    Ok(picture)
}
