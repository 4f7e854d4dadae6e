//! `pocketnerf repack` and `pocketnerf unpack`.

use std::path::PathBuf;

use pocketnerf_core::Camera;
use pocketnerf_formats::{pack, with_world};
use pocketnerf_train::cameras::Circle;
use pocketnerf_train::compact::{self, Compacted};
use pocketnerf_train::dataset::Split;
use pocketnerf_train::output;
use pocketnerf_train::picture::Settings;
use serde_json::{Value, json};

use super::model_file::ModelBytes;
use super::parse::parse_psnr;
use super::rendering::Vectors;
use super::train::WorldOptions;
use super::{Common, Failure, Reading, print_line, read_model};

#[derive(Debug, clap::Args)]
pub(super) struct Repack {
    #[command(flatten)]
    files: Files,
    /// Round tables until the file has at most so many bytes, with the least change of pictures
    #[arg(long, value_name = "N", group = "size", value_parser = clap::value_parser!(u32).range(1..))]
    max_bytes: Option<u32>,
    /// Round tables as coarsely as a PSNR of D dB against the original's pictures allows
    #[arg(long, value_name = "D", group = "size", value_parser = parse_psnr)]
    target_psnr: Option<f64>,
    /// Compare pictures from this dataset's training cameras [default: from a circle around the
    /// scene]
    #[arg(long, value_name = "DATA", requires = "size", help_heading = "Dataset")]
    data: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    world: WorldOptions,
    #[command(flatten)]
    vectors: Vectors,
}

#[derive(Debug, clap::Args)]
pub(super) struct Unpack {
    #[command(flatten)]
    files: Files,
}

/// A model file, and where its copy goes.
#[derive(Debug, clap::Args)]
struct Files {
    /// Model file
    input: PathBuf,
    /// Model file to write
    out: PathBuf,
}

impl Repack {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let mut bytes = self.files.read()?;
        let refused = |e: &dyn std::fmt::Display| format!("{}: {e}", self.files.input.display());
        if self.world.is_given() {
            let file = super::open(&self.files.input, &bytes)?;
            let world = self.world.or(file.about.world);
            let said = with_world(&file, &world).map_err(|e| refused(&e))?;
            bytes = bytes.changed(said);
        }
        if (self.max_bytes, self.target_psnr) == (None, None) {
            let packed = pack(&bytes).map_err(|e| refused(&e))?;
            return self.files.write(&bytes, &packed, (json!({}), ""), common);
        }
        let cameras = self.cameras(&bytes)?;
        let settings = Settings { simd: self.vectors.level(), ..Settings::default() };
        let least = self.target_psnr.unwrap_or(f64::INFINITY);
        let compacted = match self.max_bytes {
            Some(most) => compact::to_bytes(&bytes, most as usize, None, &cameras, &settings),
            None => compact::smallest(&bytes, &cameras, &settings, |_, error| {
                Ok(-10.0 * error.log10() >= least)
            }),
        };
        let Compacted { bytes: packed, steps, network_steps, psnr, .. } =
            compacted.map_err(|e| refused(&e))?;
        let said = match psnr.is_finite() {
            true => format!(", {psnr:.1} dB to the original"),
            false => ", the same pictures".to_owned(),
        };
        let facts = json!({
            "steps": steps,
            "network_steps": network_steps,
            "psnr_to_original": psnr,
        });
        self.files.write(&bytes, &packed, (facts, &said), common)
    }

    /// Small ones that see all of the scene.
    fn cameras(&self, bytes: &[u8]) -> Result<Vec<Camera>, Failure> {
        let file = super::open(&self.files.input, bytes)?;
        let Some(data) = &self.data else {
            let own = file.about.camera.map(|camera| camera.camera());
            let fov_x = Circle::fov_x(own.as_ref());
            let circle = Circle::around(&file.model.space, own.as_ref(), compact::VIEWS, fov_x);
            return Ok(compact::small(circle.cameras(), compact::SIDE));
        };
        let dataset = self.reading.read(data, Split::Train, 1)?;
        let (views, scene) = (dataset.views.iter(), file.about.scene);
        let cameras = views.map(|view| dataset.camera_in_model(&view.camera, &scene));
        Ok(compact::small(cameras.collect(), compact::SIDE))
    }
}

impl Unpack {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let bytes = self.files.read()?;
        self.files.write(&bytes, &bytes, (json!({}), ""), common)
    }
}

impl Files {
    fn read(&self) -> Result<ModelBytes, Failure> {
        output::check_output(&self.out)?;
        let bytes = read_model(&self.input)?;
        super::open(&self.input, &bytes)?;
        Ok(bytes)
    }

    fn write(
        &self,
        from: &ModelBytes,
        to: &[u8],
        (mut facts, said): (Value, &str),
        common: &Common,
    ) -> Result<(), Failure> {
        output::write_atomic(&self.out, to)?;
        let (before, after) = (from.stored().len(), to.len());
        if common.json {
            facts["bytes"] = after.into();
            facts["bytes_before"] = before.into();
            facts["out"] = self.out.display().to_string().into();
            common.print_json(facts, &[]);
        } else {
            print_line(format_args!(
                "{}: {after} bytes, {before} before{said}",
                self.out.display()
            ));
        }
        Ok(())
    }
}
