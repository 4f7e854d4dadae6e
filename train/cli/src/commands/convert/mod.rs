//! `pocketnerf convert`.

mod distill;
mod source;

use std::f32::consts::FRAC_PI_4;
use std::path::PathBuf;

use pocketnerf_core::{Camera, Model};
use pocketnerf_formats::{About, DefaultCamera, PixelOrigin, Precision, Provenance};
use pocketnerf_train::cameras::Orbit;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::output;
use pocketnerf_train::picture::{self, Sampling};
use serde_json::{Value, json};

use super::train::default_camera;
use super::{Common, Failure, Reading, eval, print_line, read_model};
use crate::convert::{Conversion, ConvertError, compare, refuse_others};

/// Views of an orbit that are compared where no dataset is given.
const VIEWS: usize = 4;
/// Their size.
const SIZE: [u32; 2] = [100, 100];

/// Make a model file of what another program trained, or of a model in f32.
#[derive(Debug, clap::Args)]
pub(super) struct Convert {
    /// Checkpoint of another program, or a .pnerf model or checkpoint.
    input: PathBuf,
    /// Model file to write.
    out: PathBuf,
    /// Depth where samples begin, scene units; from the config beside the checkpoint
    /// unless told.
    #[arg(long, value_name = "N")]
    near: Option<f32>,
    /// Depth where samples end.
    #[arg(long, value_name = "F")]
    far: Option<f32>,
    /// Evenly spaced samples, and samples drawn from their weights.
    #[arg(long, value_name = "C,F", value_parser = parse_samples)]
    samples: Option<[u32; 2]>,
    /// Colour behind the scene: white, black or R,G,B.
    #[arg(long, value_name = "COLOR", value_parser = super::parse_color)]
    background: Option<[f32; 3]>,
    /// Rays are those of normalised device coordinates (needs --data).
    #[arg(long)]
    ndc: bool,
    /// Near and far are distances along rays, not depths along the camera's axis.
    #[arg(long)]
    along_rays: bool,
    /// Where in a pixel rays went through: center or corner; corner unless told, as in
    /// the original program.
    #[arg(long, value_name = "WHERE", value_parser = super::parse_pixel_origin)]
    pixel_origin: Option<PixelOrigin>,
    /// Box of the scene, X0,Y0,Z0,X1,Y1,Z1; found unless told. Of a hash grid, what is shown
    /// of it, in the dataset's coordinates.
    #[arg(long, value_name = "BOX", value_parser = super::parse_box,
        allow_hyphen_values = true)]
    aabb: Option<[[f32; 3]; 2]>,
    /// Dataset that it was trained on: for normalised device coordinates, a camera to
    /// begin with, and views to verify.
    #[arg(long, value_name = "DATA")]
    data: Option<PathBuf>,
    /// Its images so many times smaller.
    #[arg(long, value_name = "K", default_value_t = 1)]
    downscale_factor: u32,
    #[command(flatten)]
    reading: Reading,
    /// The fine network of a .npy checkpoint that holds the coarse one: model_fine_* beside
    /// it unless told.
    #[arg(long, value_name = "FILE")]
    fine: Option<PathBuf>,
    /// Leave the coarse network out: half the bytes, and other pictures with
    /// --sampling hierarchical.
    #[arg(long)]
    fine_only: bool,
    /// How the model file holds weights: i8 (tables, networks in f16), f16 or f32; i8 for
    /// a distilled model unless told, else f16.
    #[arg(long, value_name = "TYPE", value_parser = super::parse_precision)]
    precision: Option<Precision>,
    /// Train a hash grid from views of the source, whose file has at most so many bytes:
    /// pictures in a fraction of the time. With --data from where its training views were
    /// taken, else from all around.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u64).range(1..))]
    distill_to: Option<u64>,
    /// Seconds that distilling trains.
    #[arg(long, value_name = "S", default_value_t = 60.0, requires = "distill_to",
        value_parser = super::parse_seconds)]
    distill_seconds: f64,
    /// When the distilled model computes colours: for every ray is faster, for every sample
    /// nearer to a source that is translucent. As the source, if that is a hash grid, else
    /// for every ray.
    #[arg(long, value_enum, value_name = "WHEN", requires = "distill_to")]
    shading: Option<When>,
    /// Render source and result on the same rays and tell how far they are apart.
    #[arg(long)]
    verify: bool,
}

/// When colours are computed.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum When {
    /// For every sample.
    PerSample,
    /// Once a ray.
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
            print_line(result);
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
                     a pixel ({:.1} in the source)",
                    number(&difference["psnr"]),
                    number(&difference["max_error"]),
                    number(&difference["evaluations"][1]),
                    number(&difference["evaluations"][0]),
                ));
            }
        }
        Ok(())
    }

    /// A model of ours in another precision.
    fn own(&self, bytes_of: &[u8], common: &Common) -> Result<Value, Failure> {
        let file = super::open(&self.input, bytes_of)?;
        if let Some(bytes) = self.distill_to {
            let mut table = Vec::new();
            let file = super::open_to_render(&self.input, bytes_of, &mut table)?;
            let own = file.about.camera.map(|camera| camera.camera());
            let distance = own.map_or(0.0, |camera| {
                Orbit::around(&file.model.space, Some(&camera), 1, 1.0).radius
            });
            return self.distill((&file.model, &file.about), bytes, (&[], distance), common);
        }
        let precision = self.precision.unwrap_or_default();
        let written = pocketnerf_formats::write(&file.model, &file.about, precision)?;
        output::write_atomic(&self.out, &written)?;
        let [mut paper, mut occupancy] = [Value::Null, Value::Null];
        if self.verify {
            let sampling = match file.model.hierarchical {
                Some(_) => Sampling::Paper,
                None => Sampling::Occupancy,
            };
            [paper, occupancy] = self.verify(&file.model, sampling, &written, &[], common)?;
        }
        let fraction = file.model.occupancy.map_or(1.0, |cells| cells.fraction());
        Ok(self.report("pocketnerf", written.len(), fraction, [paper, occupancy]))
    }

    fn other(&self, bytes: &[u8], common: &Common) -> Result<Value, Failure> {
        let named = |error: ConvertError| format!("{}: {error}", self.input.display());
        refuse_others(bytes).map_err(named)?;
        let load = |folder: &PathBuf| -> Result<Dataset, Failure> {
            Ok(self.reading.load(folder, Split::Test, self.downscale_factor, common)?)
        };
        let dataset = self.data.as_ref().map(load).transpose()?;
        let conversion = self.conversion(bytes, dataset.as_ref(), common)?;
        let model = conversion.model().map_err(named)?;
        let scene = conversion.scene();
        let of_dataset = dataset.iter().flat_map(|dataset| &dataset.views);
        let mut views: Vec<Camera> =
            of_dataset.map(|view| scene.camera_to_model(&view.camera)).collect();
        if dataset.is_none() {
            views.extend(conversion.views());
        }
        let up = scene.to_model_direction([0.0, 0.0, 1.0]);
        let camera = views.first().map_or_else(
            || default_camera(&orbit(&model, conversion.distance(), up)[0]),
            default_camera,
        );
        let about = self.about(camera, &conversion);
        if let Some(bytes) = self.distill_to {
            let mut table = vec![0; model.table_len()];
            let model = model.with_table(&mut table)?;
            let own = conversion.views();
            return self.distill((&model, &about), bytes, (own, conversion.distance()), common);
        }
        let precision = self.precision.unwrap_or_default();
        let written = pocketnerf_formats::write(&model, &about, precision)?;
        output::write_atomic(&self.out, &written)?;
        let mut verified = [Value::Null, Value::Null];
        if self.verify {
            let origin = conversion.pixel_origin();
            views.iter_mut().for_each(|camera| eval::shift(camera, origin));
            if views.is_empty() {
                views = orbit(&model, conversion.distance(), up);
            }
            let sampling = conversion.sampling();
            // The paper's sampling asks everywhere, whatever the cells.
            let occupancy = model.occupancy.filter(|_| sampling == Sampling::Occupancy);
            let source = Model { occupancy, ..model };
            verified = self.verify(&source, sampling, &written, &views, common)?;
        }
        let fraction = model.occupancy.map_or(1.0, |cells| cells.fraction());
        Ok(self.report(conversion.program(), written.len(), fraction, verified))
    }

    fn about(&self, camera: DefaultCamera, conversion: &Conversion) -> About<'_> {
        About {
            scene: conversion.scene(),
            camera: Some(camera),
            provenance: Some(Provenance {
                program: concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
                method: conversion.program(),
                ..Provenance::default()
            }),
            pixel_origin: conversion.pixel_origin(),
            quality: None,
        }
    }

    /// Compares the written file with its source, in the source's sampling and in occupied
    /// cells.
    fn verify(
        &self,
        source: &Model<'_>,
        sampling: Sampling,
        written: &[u8],
        views: &[Camera],
        common: &Common,
    ) -> Result<[Value; 2], Failure> {
        let mut table = Vec::new();
        let file = super::open_to_render(&self.out, written, &mut table)?;
        let own;
        let views = if views.is_empty() {
            let fov_x = Orbit::fov_x(None);
            own = Orbit { size: SIZE, ..Orbit::around(&source.space, None, VIEWS, fov_x) };
            &own.cameras()[..]
        } else {
            views
        };
        // The source has no interpolated pixels.
        let settings = picture::Settings { quality: 1.0, ..common.picture(None) };
        let mut compared = [Value::Null, Value::Null];
        let samplings = [Sampling::Paper, Sampling::Occupancy];
        for (to, with) in compared.iter_mut().zip(samplings) {
            if sampling == Sampling::Paper || with == Sampling::Occupancy {
                let models = [(source, sampling), (&file.model, with)];
                *to = serde_json::to_value(compare(models, views, &settings)?)?;
            }
        }
        Ok(compared)
    }

    fn report(&self, program: &str, bytes: usize, fraction: f32, verified: [Value; 2]) -> Value {
        let [paper, occupancy] = verified;
        json!({
            "bytes": bytes,
            "program": program,
            "occupancy_fraction": fraction,
            "verify_paper": paper,
            "verify_occupancy": occupancy,
            "out": self.out.display().to_string(),
        })
    }
}

/// Views all around, from as far away as the source's where that is known.
fn orbit(model: &Model<'_>, distance: f32, up: [f32; 3]) -> Vec<Camera> {
    let around = Orbit::around(&model.space, None, VIEWS, FRAC_PI_4);
    let radius = if distance > 0.0 { distance } else { around.radius };
    Orbit { size: SIZE, radius, axis: up, up, ..around }.cameras()
}

fn parse_samples(text: &str) -> Result<[u32; 2], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([coarse, fine]) => Ok([*coarse, *fine]),
        _ => Err("expected two numbers: C,F".to_owned()),
    }
}
