//! `pocketnerf train`.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use pocketnerf_core::Camera;
use pocketnerf_formats::{About, DefaultCamera, Precision, Provenance};
use serde_json::{Value, json};

use super::{Common, Failure};
use crate::dataset::{self, Dataset, Split};
use crate::field::EncodingConfig;
use crate::output;
use crate::trainer::{Length, Progress, Summary, TrainConfig, Trainer, run};

/// Learn a model from a dataset.
#[derive(Debug, clap::Args)]
pub(super) struct Train {
    /// Folder of a Blender-style dataset (transforms_train.json and images).
    data: PathBuf,
    /// Model file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Wall time from program start to the written file.
    #[arg(long, value_name = "S", default_value_t = 120.0, conflicts_with = "steps")]
    seconds: f64,
    /// Train for so many steps instead: repeatable to the bit.
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// Where random numbers begin.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Rays a step; as many as keep the steps even unless told.
    #[arg(long, value_name = "N")]
    batch_rays: Option<usize>,
    /// Train on images so many times smaller.
    #[arg(long, value_name = "K", default_value_t = 1)]
    downscale_factor: u32,
    /// Box of the scene, X0,Y0,Z0,X1,Y1,Z1; found from cameras and silhouettes
    /// unless told.
    #[arg(long, value_name = "BOX", value_parser = parse_box, allow_hyphen_values = true)]
    aabb: Option<[[f32; 3]; 2]>,
    /// Nothing is seen nearer to a camera than this, scene units.
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    near: f32,
    /// Nothing is seen farther than this; everything in the box unless told.
    #[arg(long, value_name = "N")]
    far: Option<f32>,
    /// Learn against one background: white, black or R,G,B. Images with alpha
    /// are trained on random ones unless told.
    #[arg(long, value_name = "COLOR", value_parser = super::parse_color)]
    background: Option<[f32; 3]>,
    /// Base-two logarithm of the most entries of a grid level.
    #[arg(long, value_name = "N")]
    log2_hashmap_size: Option<u32>,
}

fn parse_box(text: &str) -> Result<[[f32; 3]; 2], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([a, b, c, d, e, f]) => Ok([[*a, *b, *c], [*d, *e, *f]]),
        _ => Err("expected six numbers: X0,Y0,Z0,X1,Y1,Z1".to_owned()),
    }
}

impl Train {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        output::check_output(&self.out)?;
        if !(self.seconds > 0.0 && self.seconds < 1e7) {
            return Err(format!("--seconds {}: expected a positive number", self.seconds).into());
        }
        if self.batch_rays == Some(0) {
            return Err("--batch-rays 0: expected at least one ray".into());
        }
        let dataset = dataset::load(&self.data, Split::Train, self.downscale_factor)?;
        let mut config = TrainConfig::hash_grid();
        config.seed = self.seed;
        config.aabb = self.aabb;
        config.near = self.near;
        config.far = self.far;
        config.batch_rays = self.batch_rays;
        config.backdrop = self.background;
        if let (EncodingConfig::HashGrid(grid), Some(n)) =
            (&mut config.field.encoding, self.log2_hashmap_size)
        {
            grid.log2_hashmap_size = n;
        }
        let length = self.steps.map_or(Length::Seconds(self.seconds), Length::Steps);
        let result = train(dataset, config, length, &self.out, common)?;
        if common.json {
            println!("{result}");
        } else {
            println!(
                "{}: {} bytes, {} steps, training PSNR {:.2} dB, {:.1} s",
                self.out.display(),
                result["bytes"],
                result["steps"],
                result["train_psnr"].as_f64().unwrap_or(f64::NAN),
                result["seconds"].as_f64().unwrap_or(f64::NAN),
            );
        }
        Ok(())
    }
}

/// Trains and writes the model; gives the keys that `train --json` prints.
pub(super) fn train(
    dataset: Dataset,
    config: TrainConfig,
    length: Length,
    out: &Path,
    common: &Common,
) -> Result<Value, Failure> {
    let (name, fingerprint) = (dataset.source.clone(), dataset.fingerprint());
    let name = Path::new(&name).file_name().map_or_else(String::new, |n| n.display().to_string());
    let camera = dataset.views.first().map(|v| v.camera);
    let seed = config.seed;
    let mut trainer = Trainer::new(dataset, config, common.simd())?;
    let mut bar = Bar::new(common.quiet);
    let summary: Summary = run(&mut trainer, length, common.started, |p| bar.show(p))?;
    bar.finish();
    let about = About {
        camera: camera.map(|c| default_camera(&c)),
        provenance: Some(Provenance {
            program: concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
            method: "hash-grid",
            seed,
            steps: u64::from(trainer.steps()),
            trained_on: fingerprint,
            dataset: &name,
            train_psnr: Some(summary.train_psnr as f32),
        }),
        ..About::default()
    };
    let bytes = pocketnerf_formats::write(&trainer.model(), &about, Precision::F16)?;
    output::write_atomic(out, &bytes)?;
    let seconds = common.started.elapsed().as_secs_f64();
    Ok(json!({
        "seconds": seconds,
        "steps": trainer.steps(),
        "restarts": summary.restarts,
        "rays": summary.rays,
        "samples": summary.samples,
        "samples_per_second": summary.samples as f64 / seconds,
        "train_psnr": summary.train_psnr,
        "bytes": bytes.len(),
        "peak_memory_bytes": super::peak_memory_bytes(),
        "seed": seed,
        "threads": rayon::current_num_threads(),
        "method": "hash-grid",
        "out": out.display().to_string(),
    }))
}

/// The first training camera: where a viewer may begin.
fn default_camera(camera: &Camera) -> DefaultCamera {
    DefaultCamera {
        camera_to_world: camera.camera_to_world,
        fov_x: 2.0 * (0.5 * camera.width as f32 / camera.focal[0]).atan(),
        width: camera.width,
        height: camera.height,
    }
}

/// Progress: a bar on a terminal, a line now and then in a pipe.
struct Bar {
    bar: Option<ProgressBar>,
    quiet: bool,
    last: std::time::Instant,
}

impl Bar {
    fn new(quiet: bool) -> Self {
        let terminal = !quiet && std::io::stderr().is_terminal();
        let style = "training {wide_bar} {pos}/{len} steps, {msg}, {eta} left";
        let bar = terminal.then(|| {
            let style = ProgressStyle::with_template(style).expect("a valid template");
            ProgressBar::new(0).with_style(style)
        });
        Self { bar, quiet, last: std::time::Instant::now() }
    }

    fn show(&mut self, progress: Progress) {
        let psnr = format!("training PSNR {:.2} dB", progress.train_psnr);
        if let Some(bar) = &self.bar {
            bar.set_length(u64::from(progress.steps.unwrap_or(0)));
            bar.set_position(u64::from(progress.step));
            bar.set_message(psnr);
        } else if !self.quiet && self.last.elapsed().as_secs() >= 10 {
            self.last = std::time::Instant::now();
            let steps = progress.steps.map_or_else(|| "?".to_owned(), |n| n.to_string());
            eprintln!("step {} of {steps}, {psnr}", progress.step);
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
