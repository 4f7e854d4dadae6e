//! `pocketnerf convert`.

mod distill;
mod source;

use std::f32::consts::FRAC_PI_4;
use std::path::PathBuf;

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{Camera, Model, Space};
use pocketnerf_formats::import::{Checkpoint, inflate};
use pocketnerf_formats::{
    About, DefaultCamera, PhotographList, PixelOrigin, Precision, Provenance, Scene,
};
use pocketnerf_train::cameras::Circle;
use pocketnerf_train::convert::ConvertError;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::output;
use pocketnerf_train::picture::{self, Sampling};
use serde_json::{Value, json};

use super::parse::{
    parse_box, parse_color, parse_pixel_origin, parse_positive_seconds, parse_precision,
};
use super::rendering::Rendering;
use super::train::default_camera;
use super::{Common, Failure, Reading, eval, print_line, read_model};
use crate::convert::{compare_models, instead, refuse_others};

/// Views of an orbit that are compared if no dataset is given.
const VIEWS: usize = 4;
/// Their size.
const SIZE: [u32; 2] = [100, 100];

#[derive(Debug, clap::Args)]
pub(super) struct Convert {
    /// Checkpoint of another program, or a .pnerf model or checkpoint
    input: PathBuf,
    /// Model file to write
    out: PathBuf,
    /// Format of the weights: i8 (networks: f16), f16 or f32 [default: f16; i8 with
    /// --distill-to]
    #[arg(long, value_name = "TYPE", value_parser = parse_precision)]
    precision: Option<Precision>,
    /// Render source and result on the same rays and report how they differ
    #[arg(long)]
    verify: bool,
    /// Dataset that the source was trained on: for normalised device coordinates, the default
    /// camera, and views to verify
    #[arg(long, value_name = "DATA", help_heading = "Dataset")]
    data: Option<PathBuf>,
    /// Downscale its images by this factor
    #[arg(long, value_name = "K", default_value_t = 1, help_heading = "Dataset")]
    downscale_factor: u32,
    /// Where the source's rays passed through pixels: center or corner [default: corner, as
    /// in the original NeRF]
    #[arg(long, value_name = "WHERE", value_parser = parse_pixel_origin, help_heading = "Dataset")]
    pixel_origin: Option<PixelOrigin>,
    #[command(flatten)]
    reading: Reading,
    /// Box of the scene, X0,Y0,Z0,X1,Y1,Z1; of a hash grid: the part to show, in the dataset's
    /// coordinates [default: found]
    #[arg(long, value_name = "BOX", value_parser = parse_box, allow_hyphen_values = true,
        help_heading = "Scene")]
    aabb: Option<[[f32; 3]; 2]>,
    /// The source uses normalised device coordinates (needs --data)
    #[arg(long, help_heading = "Scene")]
    ndc: bool,
    /// Depth where samples begin, scene units [default: as the config beside the checkpoint
    /// says]
    #[arg(long, value_name = "N", help_heading = "Scene")]
    near: Option<f32>,
    /// Depth where samples end, scene units [default: as the config beside the checkpoint
    /// says]
    #[arg(long, value_name = "F", help_heading = "Scene")]
    far: Option<f32>,
    /// Near and far are distances along rays, not depths along the camera's axis
    #[arg(long, help_heading = "Scene")]
    along_rays: bool,
    /// Colour behind the scene: white, black or R,G,B
    #[arg(long, value_name = "COLOR", value_parser = parse_color, help_heading = "Scene")]
    background: Option<[f32; 3]>,
    /// Coarse and fine samples per ray
    #[arg(long, value_name = "C,F", value_parser = parse_samples, help_heading = "Model")]
    samples: Option<[u32; 2]>,
    /// What svox2 multiplied the dataset's positions by [default: 2/3, as it does for Blender's
    /// datasets]
    #[arg(long, value_name = "S", value_parser = parse_scale, help_heading = "Scene")]
    scene_scale: Option<f32>,
    /// Fine network of a .npy checkpoint that holds the coarse one [default: model_fine_*
    /// beside it]
    #[arg(long, value_name = "FILE", help_heading = "Model")]
    fine: Option<PathBuf>,
    /// Omit the coarse network: half the bytes, but different pictures with --sampling
    /// hierarchical
    #[arg(long, help_heading = "Model")]
    fine_only: bool,
    /// Train a hash grid of at most so many bytes on renderings of the source, which renders
    /// many times faster [default: no; 5000000 for TensoRF and svox2]
    ///
    /// The views are those of the training images with --data, else views from all around.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u64).range(1..),
        help_heading = "Distillation")]
    distill_to: Option<u64>,
    /// Training time of the distilled model: 90, 90s, 2m
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "distill_to",
        value_parser = parse_positive_seconds, help_heading = "Distillation")]
    distill_seconds: f64,
    /// When the distilled model computes colours [default: as a hash grid source does, else
    /// per-ray]
    #[arg(
        long,
        value_enum,
        value_name = "WHEN",
        requires = "distill_to",
        help_heading = "Distillation"
    )]
    shading: Option<When>,
    #[command(flatten)]
    rendering: Rendering,
}

/// When colours are computed.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum When {
    /// For every sample: closer to translucent sources
    PerSample,
    /// Once per ray: faster
    PerRay,
}

impl Convert {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        output::check_output(&self.out)?;
        let bytes = read_model(&self.input)?;
        let result = if bytes.starts_with(&pocketnerf_formats::MAGIC) {
            self.own(&bytes, common)?
        } else {
            self.other(&bytes, common)?
        };
        if common.json {
            common.print_json(result, &[]);
        } else {
            print_line(format_args!(
                "{}: {} bytes, {}, occupied cells {:.1} %",
                self.out.display(),
                result["bytes"],
                result["program"].as_str().unwrap_or_default(),
                100.0 * result["occupancy_fraction"].as_f64().unwrap_or(1.0),
            ));
            for (what, key) in
                [("the source's sampling", "verify_paper"), ("occupied cells", "verify_occupancy")]
            {
                let Some(difference) = result.get(key).filter(|d| !d.is_null()) else { continue };
                let number = |of: &Value| of.as_f64().unwrap_or(f64::INFINITY);
                print_line(format_args!(
                    "with {what}: {:.2} dB to the source, largest error {:.5}, {:.1} evaluations \
                     per pixel ({:.1} in the source)",
                    number(&difference["psnr"]),
                    number(&difference["max_error"]),
                    number(&difference["evaluations"][1]),
                    number(&difference["evaluations"][0]),
                ));
            }
        }
        Ok(())
    }

    /// Writes one of our models in another precision.
    fn own(&self, bytes_of: &[u8], common: &Common) -> Result<Value, Failure> {
        let file = super::open(&self.input, bytes_of)?;
        if let Some(bytes) = self.distill_to {
            let mut table = Vec::new();
            let file = super::open_to_render(&self.input, bytes_of, &mut table)?;
            let own = file.about.camera.map(|camera| camera.camera());
            let distance = own.map_or(0.0, |camera| {
                Circle::around(&file.model.space, Some(&camera), 1, 1.0).first.radius
            });
            return self.distill_model((&file.model, &file.about), bytes, (&[], distance), common);
        }
        let precision = self.precision.unwrap_or_default();
        let written = pocketnerf_formats::write(&file.model, &file.about, precision)?;
        output::write_atomic(&self.out, &written)?;
        let [mut hierarchical, mut occupancy] = [Value::Null, Value::Null];
        if self.verify {
            let sampling = match file.model.hierarchical {
                Some(_) => Sampling::Hierarchical,
                None => Sampling::Occupancy,
            };
            [hierarchical, occupancy] = self.verify(&file.model, sampling, &written, &[])?;
        }
        let fraction = file.model.occupancy.map_or(1.0, |cells| cells.fraction());
        Ok(self.report("pocketnerf", written.len(), fraction, [hierarchical, occupancy]))
    }

    fn other(&self, bytes: &[u8], common: &Common) -> Result<Value, Failure> {
        let named = |error: ConvertError| format!("{}: {error}", self.input.display());
        refuse_others(bytes).map_err(named)?;
        let load = |folder: &PathBuf| -> Result<Dataset, Failure> {
            Ok(self.reading.load(folder, Split::Test, self.downscale_factor, common)?)
        };
        let dataset = self.data.as_ref().map(load).transpose()?;
        let unpacked = inflate(bytes).map_err(|error| named(error.into()))?;
        let better = |error: ConvertError| -> Failure { named(instead(&unpacked, error)).into() };
        let checkpoint = Checkpoint::read(&unpacked).map_err(|error| better(error.into()))?;
        if let Some(volume) = self.volume(&checkpoint)? {
            return self.learn(&volume, dataset.as_ref(), common);
        }
        let conversion = self.conversion(&checkpoint, better, dataset.as_ref(), common)?;
        let model = conversion.model().map_err(named)?;
        let scene = conversion.scene();
        let mut views = match &dataset {
            Some(dataset) => cameras_of(dataset, &scene),
            None => conversion.views().to_vec(),
        };
        let up = scene.to_model_direction([0.0, 0.0, 1.0]);
        let camera = views.first().map_or_else(
            || default_camera(&orbit(&model.space, conversion.distance(), up)[0]),
            default_camera,
        );
        let photographs = PhotographList::new(conversion.views());
        let photographs = photographs.as_ref().map(PhotographList::view);
        let about = About {
            photographs,
            pixel_origin: conversion.pixel_origin(),
            ..about(camera, scene, conversion.program())
        };
        if let Some(bytes) = self.distill_to {
            let mut table = vec![0; model.table_len()];
            let model = model.with_table(&mut table)?;
            let own = conversion.views();
            let own = (own, conversion.distance());
            return self.distill_model((&model, &about), bytes, own, common);
        }
        let precision = self.precision.unwrap_or_default();
        let written = pocketnerf_formats::write(&model, &about, precision)?;
        output::write_atomic(&self.out, &written)?;
        let mut verified = [Value::Null, Value::Null];
        if self.verify {
            let origin = conversion.pixel_origin();
            views.iter_mut().for_each(|camera| eval::shift(camera, origin, 1));
            if views.is_empty() {
                views = orbit(&model.space, conversion.distance(), up);
            }
            let sampling = conversion.sampling();
            // Hierarchical sampling ignores the cells.
            let occupancy = model.occupancy.filter(|_| sampling == Sampling::Occupancy);
            let source = Model { occupancy, ..model };
            verified = self.verify(&source, sampling, &written, &views)?;
        }
        let fraction = model.occupancy.map_or(1.0, |cells| cells.fraction());
        Ok(self.report(conversion.program(), written.len(), fraction, verified))
    }

    /// Compares the written file with its source, in the source's sampling and in occupied
    /// cells.
    fn verify(
        &self,
        source: &Model<'_>,
        sampling: Sampling,
        written: &[u8],
        views: &[Camera],
    ) -> Result<[Value; 2], Failure> {
        let mut table = Vec::new();
        let file = super::open_to_render(&self.out, written, &mut table)?;
        let own;
        let views = if views.is_empty() {
            let fov_x = Circle::fov_x(None);
            own = Circle { size: SIZE, ..Circle::around(&source.space, None, VIEWS, fov_x) };
            &own.cameras()[..]
        } else {
            views
        };
        // The source has no interpolated pixels.
        let settings = picture::Settings { quality: 1.0, ..self.rendering.settings(None) };
        let mut compared = [Value::Null, Value::Null];
        let samplings = [Sampling::Hierarchical, Sampling::Occupancy];
        for (to, with) in compared.iter_mut().zip(samplings) {
            if sampling == Sampling::Hierarchical || with == Sampling::Occupancy {
                let models = [(source, sampling), (&file.model, with)];
                *to = serde_json::to_value(compare_models(models, views, &settings)?)?;
            }
        }
        Ok(compared)
    }

    fn report(&self, program: &str, bytes: usize, fraction: f32, verified: [Value; 2]) -> Value {
        let [hierarchical, occupancy] = verified;
        json!({
            "bytes": bytes,
            "program": program,
            "occupancy_fraction": fraction,
            "verify_paper": hierarchical,
            "verify_occupancy": occupancy,
            "out": self.out.display().to_string(),
        })
    }
}

/// What a file says of a model that another program made.
fn about(camera: DefaultCamera, scene: Scene<'static>, program: &'static str) -> About<'static> {
    About {
        scene,
        camera: Some(camera),
        provenance: Some(Provenance {
            program: concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
            method: program,
            ..Provenance::default()
        }),
        ..About::default()
    }
}

/// The cameras of a dataset, in a model's coordinates.
fn cameras_of(dataset: &Dataset, scene: &Scene<'_>) -> Vec<Camera> {
    let views = dataset.views.iter();
    views.map(|view| dataset.camera_in_model(&view.camera, scene)).collect()
}

/// Views all around, from the distance of the source's cameras if that is known.
fn orbit(space: &Space, distance: f32, up: [f32; 3]) -> Vec<Camera> {
    let around = Circle::around(space, None, VIEWS, FRAC_PI_4);
    let radius = if distance > 0.0 { distance } else { around.first.radius };
    let first = Orbit { radius, axis: up, up, ..around.first };
    Circle { size: SIZE, first, ..around }.cameras()
}

fn parse_scale(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(scale) if (1e-4..=1e4).contains(&scale) => Ok(scale),
        _ => Err("expected a number from 0.0001 to 10000".to_owned()),
    }
}

fn parse_samples(text: &str) -> Result<[u32; 2], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([coarse, fine]) => Ok([*coarse, *fine]),
        _ => Err("expected two numbers: C,F".to_owned()),
    }
}
