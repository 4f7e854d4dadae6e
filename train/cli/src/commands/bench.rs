//! `pocketnerf bench`.

use std::path::PathBuf;

#[cfg(feature = "gpu")]
use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{About, DefaultCamera, Precision};
use pocketnerf_train::builtin;
use pocketnerf_train::cameras::Circle;
use pocketnerf_train::dataset::{Dataset, LoadOptions, Split};
use pocketnerf_train::trainer::{TrainConfig, ndc_of};

use super::rendering::Rendering;
use super::{Common, Failure, open, open_to_render, print_line, read_model, reading};
use crate::bench::{Report, networks, rendering, training};
use crate::machine::{self, Machine};

/// Views that are rendered.
const VIEWS: usize = 3;

#[derive(Debug, clap::Args)]
pub(super) struct Bench {
    /// Model file to render [default: the model that the bench trains]
    model: Option<PathBuf>,
    /// Dataset folder, or built-in scene as for `train`, to train on [default: builtin]
    #[arg(long, value_name = "DATA")]
    data: Option<PathBuf>,
    /// Training steps, the first fifth of which warms up
    #[arg(long, value_name = "N", default_value_t = 1000,
        value_parser = clap::value_parser!(u32).range(10..))]
    steps: u32,
    /// Picture width [default: as the model file says]
    #[arg(long, value_name = "W", value_parser = clap::value_parser!(u32).range(1..=16_384))]
    width: Option<u32>,
    /// Picture height [default: as the model file says]
    #[arg(long, value_name = "H", value_parser = clap::value_parser!(u32).range(1..=16_384))]
    height: Option<u32>,
    /// Check in a few seconds that everything works: a small field, small pictures, rough
    /// figures
    #[arg(long)]
    quick: bool,
    /// Device that trains: of a GPU, training alone is measured, kernel by kernel
    #[cfg(feature = "gpu")]
    #[arg(long, value_enum, value_name = "DEVICE", default_value_t)]
    device: super::device::Kind,
    #[command(flatten)]
    rendering: Rendering,
}

impl Bench {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let given = self.model.as_deref().map(read_model).transpose()?;
        if let (Some(path), Some(bytes)) = (&self.model, &given) {
            // Refused before long work.
            open(path, bytes)?;
        }
        let dataset = self.dataset()?;
        let (name, first) = (dataset.source.clone(), default_camera(&dataset));
        let simd = self.rendering.vectors.level();
        #[cfg(feature = "gpu")]
        if self.device == super::device::Kind::Gpu {
            return self.on_gpu(common, dataset, simd);
        }
        say(common, "measuring the machine");
        let machine = Machine::measure(simd, self.quick)?;
        say(common, "measuring the networks of vanilla NeRF");
        let networks = networks::measure(simd, &machine)?;
        say(common, &format!("training on {name}"));
        let (steps, mut config) = self.training();
        if dataset.forward_facing {
            config.ndc = ndc_of(&dataset.views, 1.0);
        }
        let (trainer, training) = training::measure(dataset, config, steps, simd, &machine)?;
        let (path, bytes) = match (&self.model, given) {
            (Some(path), Some(bytes)) => (path.clone(), bytes.to_vec()),
            _ => {
                let about = About { camera: first, ..About::default() };
                let bytes = pocketnerf_formats::write(&trainer.model(), &about, Precision::I8)?;
                (PathBuf::from("the trained model"), bytes)
            }
        };
        drop(trainer);
        say(common, &format!("rendering {}", path.display()));
        let mut table = Vec::new();
        let file = open_to_render(&path, &bytes, &mut table)?;
        let own = file.about.camera.map(|c| c.camera());
        let fov_x = Circle::fov_x(own.as_ref());
        let circle = Circle::around(&file.model.space, own.as_ref(), VIEWS, fov_x);
        let [width, height] = if self.quick { [48; 2] } else { circle.size };
        let size = [self.width.unwrap_or(width), self.height.unwrap_or(height)];
        let cameras = Circle { size, ..circle }.cameras();
        let options = self.rendering.settings(file.about.quality).options(&file.model);
        let rendering = rendering::measure(&file.model, &cameras, &options, &machine, self.quick)?;
        let model = path.display().to_string();
        let clock = machine::clock_now(self.quick);
        let report = Report::new(&machine, networks, (name, training), (model, rendering), clock);
        if common.json {
            common.print_json(serde_json::to_value(&report)?, &[]);
        } else {
            print_line(report.to_string().trim_end());
        }
        Ok(())
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(&self, common: &Common, dataset: Dataset, simd: SimdLevel) -> Result<(), Failure> {
        let (device, why) = self.device.open();
        if let Some(why) = why {
            return Err(crate::bench::BenchError::Device(why).into());
        }
        let (steps, mut config) = self.training();
        if dataset.forward_facing {
            config.ndc = ndc_of(&dataset.views, 1.0);
        }
        say(common, &format!("training on {}", dataset.source));
        let report = crate::bench::on_gpu::measure(dataset, config, steps, simd, device)?;
        if common.json {
            common.print_json(serde_json::to_value(&report)?, &[]);
        } else {
            print_line(report.to_string().trim_end());
        }
        Ok(())
    }

    fn dataset(&self) -> Result<Dataset, Failure> {
        Ok(match &self.data {
            Some(folder) => reading::read(folder, Split::Train, &LoadOptions::default())?,
            None => builtin::dataset(Split::Train, if self.quick { 16 } else { 1 }),
        })
    }

    /// Steps and settings of the run that is timed.
    fn training(&self) -> (u32, TrainConfig) {
        let mut config = TrainConfig::hash_grid();
        if !self.quick {
            return (self.steps, config);
        }
        if let Some(field) = config.field.hash_grid_mut() {
            (field.grid.n_levels, field.grid.log2_hashmap_size) = (4, 12);
        }
        config.occupancy_resolution = 32;
        config.samples_per_side = 64.0;
        config.samples_per_step = 4096;
        (self.steps.min(120), config)
    }
}

/// Progress, for people who wait.
fn say(common: &Common, line: &str) {
    if !common.quiet {
        eprintln!("{line}");
    }
}

/// The first training camera.
fn default_camera(dataset: &Dataset) -> Option<DefaultCamera> {
    dataset.views.first().map(|view| super::train::default_camera(&view.camera))
}
