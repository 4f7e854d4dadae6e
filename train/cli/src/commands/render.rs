//! `pocketnerf render`.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{Camera, Display, Model};
use pocketnerf_formats::ModelFile;
use pocketnerf_train::cameras::{self, Circle};
use pocketnerf_train::output;
use pocketnerf_train::picture::{self, Antialias, Device, Picture, Progressive, image_file};
use serde_json::json;

use super::antialias::{Antialiasing, size_doubt};
use super::device::{self, DeviceOption};
use super::parse::parse_color;
use super::rendering::{Rendering, Sampling};
use super::{Common, Failure, make_folder, memory, open_to_render, print_json, read_model};

#[derive(Debug, clap::Args)]
pub(super) struct Render {
    /// Model file
    model: PathBuf,
    /// File for one picture, folder for several
    #[arg(long, value_name = "FILE|DIR", default_value = "render.png")]
    out: PathBuf,
    /// Render N views on a circle around the scene
    #[arg(long, value_name = "N")]
    orbit: Option<usize>,
    /// Camera-to-world pose in the dataset's coordinates, as text or a file: 16 numbers or
    /// 4 rows of 4
    #[arg(long, value_name = "JSON", conflicts_with_all = ["camera_path", "orbit"])]
    pose: Option<String>,
    /// Camera path: nerfstudio's camera_path.json or a transforms.json
    #[arg(long, value_name = "JSON", conflicts_with = "orbit")]
    camera_path: Option<PathBuf>,
    /// Picture width [default: as the model file says]
    #[arg(long, value_name = "W")]
    width: Option<u32>,
    /// Picture height [default: as the model file says]
    #[arg(long, value_name = "H")]
    height: Option<u32>,
    /// Horizontal field of view, degrees [default: as the model file says]
    #[arg(long, value_name = "DEG")]
    fov: Option<f32>,
    /// Colour behind the scene: white, black or R,G,B [default: as the model file says]
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    background: Option<[f32; 3]>,
    /// Also write depth, as 16-bit PNG in thousandths of a scene unit
    #[arg(long)]
    depth: bool,
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
        let bytes = read_model(&self.model)?;
        let mut table = Vec::new();
        let file = open_to_render(&self.model, &bytes, &mut table)?;
        let cameras = self.cameras(&file)?;
        let own = &file.model.display;
        let background = self.background.map(|color| own.color_space.from_srgb(color));
        let display = Display { background: background.unwrap_or(own.background), ..*own };
        let folder = (cameras.len() > 1).then(|| make_folder(&self.out)).transpose()?;
        if folder.is_none() {
            output::check_output(&self.out)?;
        }
        let (depth, sampling) = (self.depth, self.sampling.into());
        let antialias = self.antialiasing.of(&file.about);
        let usual = self.rendering.settings(file.about.quality);
        let settings = picture::Settings { depth, sampling, antialias, ..usual };
        // With a deadline, all rays are kept until the end.
        let kept = if self.deadline_ms.is_some() { antialias } else { Antialias::Off };
        memory::check(picture_bytes(&cameras, kept), "render smaller pictures", || {
            "a picture".to_owned()
        })?;
        let first = cameras.first();
        let doubt = first.and_then(|camera| size_doubt(&file, camera, antialias));
        let mut warnings = Vec::new();
        let mut warn = |warning: Option<String>| {
            if let (Some(warning), false) = (&warning, common.quiet) {
                eprintln!("warning: {warning}");
            }
            warnings.extend(warning);
        };
        warn(doubt);
        let (on, no_device) = self.device.open();
        warn(no_device);
        let mut renderer = picture::Renderer::on(&on, &file.model, &settings);
        let mut refined;
        let mut seconds = 0.0;
        for (i, camera) in cameras.iter().enumerate() {
            let path = match &folder {
                Some(folder) => folder.join(format!("{i:03}.png")),
                None => self.out.clone(),
            };
            let begun = Instant::now();
            let rendered = match self.deadline_ms {
                None => renderer.render(camera)?,
                Some(ms) => {
                    let within = Duration::from_millis(ms.into());
                    refined = in_time(&file.model, camera, &settings, within, common)?;
                    &refined
                }
            };
            seconds += begun.elapsed().as_secs_f64();
            let rgb = rendered.rgb8(&display);
            image_file::write_rgb(&path, camera.width, camera.height, &rgb)?;
            if self.depth {
                let (path, per_step) = (depth_path(&path), image_file::DEPTH_UNITS_PER_STEP);
                let size = (camera.width, camera.height);
                image_file::write_depth(&path, size.0, size.1, &rendered.depth, per_step)?;
            }
        }
        let refined = self.deadline_ms.map(|_| "--deadline-ms is for the CPU");
        let fallback = renderer.fallback().or(refined);
        let device = device::name(&on, fallback);
        if !matches!(on, Device::Cpu) {
            warn(fallback.map(device::on_cpu));
        }
        if common.json {
            let n = cameras.len();
            let object = json!({
                "model": self.model.display().to_string(),
                "bytes": bytes.stored().len(),
                "method": file.model.field.kind(),
                "pictures": n,
                "width": first.map(|camera| camera.width),
                "height": first.map(|camera| camera.height),
                "rays_per_pixel": first.map(|camera| antialias.rays(camera).pow(2)),
                "seconds_per_frame": seconds / n.max(1) as f64,
                "threads": rayon::current_num_threads(),
                "device": device,
                "out": self.out.display().to_string(),
            });
            print_json(object, &warnings);
        } else if !common.quiet {
            let pictures = if cameras.len() == 1 { "picture" } else { "pictures" };
            common.say(&format!("{}: {} {pictures}", self.out.display(), cameras.len()));
        }
        Ok(())
    }

    fn cameras(&self, file: &ModelFile<'_>) -> Result<Vec<Camera>, Failure> {
        let own = file.about.camera.map(|c| c.camera());
        let scene = &file.about.scene;
        let size = [
            self.width.or(own.map(|c| c.width)).unwrap_or(400),
            self.height.or(own.map(|c| c.height)).unwrap_or(400),
        ];
        if size.iter().any(|side| !(1..=16_384).contains(side)) {
            return Err(format!("picture size {size:?}: expected 1 to 16384 a side").into());
        }
        let fov_x = self.fov.map_or_else(|| Circle::fov_x(own.as_ref()), f32::to_radians);
        if !(0.01..3.1).contains(&fov_x) {
            return Err(format!(
                "field of view {:.1}: expected 1 to 177 degrees",
                fov_x.to_degrees()
            )
            .into());
        }
        if let Some(path) = &self.camera_path {
            let given = (self.width.is_some() && self.height.is_some()).then_some(size);
            let cameras = cameras::camera_path(path, given)?;
            return Ok(cameras.iter().map(|camera| scene.camera_to_model(camera)).collect());
        }
        if let Some(pose) = &self.pose {
            let pose = cameras::pose(pose)?;
            let camera = Camera::from_fov_x(size[0], size[1], fov_x, pose);
            return Ok(vec![scene.camera_to_model(&camera)]);
        }
        if let (None, Some(own)) = (self.orbit, own) {
            let pose = own.camera_to_world;
            return Ok(vec![Camera::from_fov_x(size[0], size[1], fov_x, pose)]);
        }
        let views = self.orbit.unwrap_or(1);
        if !(1..=10_000).contains(&views) {
            return Err(format!("--orbit {views}: expected 1 to 10000 views").into());
        }
        let mut circle = Circle::around(&file.model.space, own.as_ref(), views, fov_x);
        let [axis, up] = [circle.first.axis, circle.first.up].map(|d| scene.to_model_direction(d));
        circle.first = Orbit { axis, up, ..circle.first };
        Ok(Circle { size, ..circle }.cameras())
    }
}

/// Memory of the largest picture: colours and depths of its rays that are kept, and the bytes
/// that are written.
fn picture_bytes(cameras: &[Camera], kept: Antialias) -> u64 {
    let bytes = |camera: &Camera| {
        let fine = camera.finer(kept.rays(camera));
        32 * u64::from(fine.width) * u64::from(fine.height)
    };
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

/// `view.png` → `view.depth.png`.
fn depth_path(path: &Path) -> PathBuf {
    path.with_extension("depth.png")
}
