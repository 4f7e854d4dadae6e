//! `pocketnerf demo`.

use std::path::PathBuf;

use pocketnerf_formats::Precision;
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::evaluate::{Evaluation, evaluate};
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::image_file;
use pocketnerf_train::trainer::{Length, Run, RunError, TrainConfig, Trainer};

use super::parse::parse_seconds;
use super::rendering::Rendering;
use super::{Common, Failure, make_folder, open_to_render, print_line, read_model, train};

#[derive(Debug, clap::Args)]
pub(super) struct Demo {
    /// Folder for the model and the pictures
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    /// Wall time until the model is written: 90, 90s, 2m
    #[arg(long, value_name = "TIME", default_value = "75s", value_parser = parse_seconds)]
    seconds: f64,
    /// log2 of the maximum entries per grid level (controls model size)
    #[arg(long, value_name = "N", default_value_t = 15,
        value_parser = clap::value_parser!(u32).range(3..=24))]
    log2_hashmap_size: u32,
    #[command(flatten)]
    rendering: Rendering,
}

impl Demo {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let folder = make_folder(&self.out)?;
        let dataset = builtin::dataset(Split::Train, 1);
        let held_out = builtin::dataset(Split::Test, 1);
        let mut config = TrainConfig::hash_grid();
        if let Some(field) = config.field.hash_grid_mut() {
            let grid = &mut field.grid;
            grid.n_levels = 8;
            grid.log2_hashmap_size = self.log2_hashmap_size;
            grid.base_resolution = 10;
            grid.per_level_scale = 1.85;
        }
        let mut bar = train::Bar::new(common);
        bar.phase("finding the scene");
        let path = folder.join("scene.pnerf");
        let origin = train::Origin::new(&dataset, 1, Precision::I8, dataset.world());
        let mut trainer = Trainer::with_prepass(dataset, config, self.rendering.vectors.level())?;
        let mut run = Run::new(Length::Seconds(self.seconds), common.started);
        train::train(&mut trainer, &mut run, &mut bar, |_, _, _| Ok(())).map_err(in_demo)?;
        let never = || false;
        let finished = train::finish(&trainer, &run, &origin, (&path, &never), &mut bar)?;
        let mut value = finished.unwrap_or_default();
        drop(bar);
        let bytes = read_model(&path)?;
        let mut table = Vec::new();
        let file = open_to_render(&path, &bytes, &mut table)?;
        let background = file.model.display.srgb_background();
        let mut failure = None;
        let (settings, metrics) = (self.rendering.settings(None), Metrics::default());
        let result =
            evaluate(&file.model, &held_out, background, &settings, &metrics, |i, a, b| {
                let camera = &held_out.views[i].camera;
                let (width, pixels) = image_file::side_by_side(camera.width, &[a, b]);
                let to = folder.join(format!("view_{i:02}.png"));
                let written = image_file::write_rgb(&to, width, camera.height, &pixels);
                failure = written.err().or(failure.take());
            })?;
        if let Some(failure) = failure {
            return Err(failure.into());
        }
        if common.json {
            let scores = serde_json::to_value(&result)?;
            if let (Some(all), Some(scores)) = (value.as_object_mut(), scores.as_object()) {
                all.extend(scores.clone());
            }
            common.result(value);
        } else {
            print_line(format_args!(
                "{}: {} bytes, held-out PSNR {:.2} dB on white{}, {:.3} s per frame, {:.1} s in \
                 total; renderings beside the truth: {}/view_*.png",
                path.display(),
                bytes.len(),
                result.psnr,
                depths(&result),
                result.seconds_per_frame,
                common.started.elapsed().as_secs_f64(),
                folder.display(),
            ));
        }
        Ok(())
    }
}

/// The demo has fewer options than training, whose advice names them.
fn in_demo(failure: Failure) -> Failure {
    match failure.downcast_ref() {
        Some(RunError::NoTime(no_time)) => format!(
            "--seconds {}: tracing the scene and finding it takes {:.1} s, which leaves no time to \
             train; expected at least {}",
            no_time.seconds,
            no_time.before,
            no_time.least()
        )
        .into(),
        _ => failure,
    }
}

/// Errors of depths and silhouettes.
fn depths(result: &Evaluation) -> String {
    let (Some(error), Some(missed)) = (result.depth_error, result.depth_missed) else {
        return String::new();
    };
    format!(
        ", mean depth error {error:.3}, silhouettes differ in {:.1} % of pixels",
        100.0 * missed
    )
}
