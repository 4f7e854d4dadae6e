//! `pocketnerf convert --distill-to`.

use std::time::Instant;

use pocketnerf_core::field::Shading;
use pocketnerf_core::{Camera, Display, Model, Space};
use pocketnerf_formats::{About, Precision};
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::output;
use pocketnerf_train::picture::{self, Sampling};
use pocketnerf_train::trainer::{Length, Run, Trainer};
use serde_json::Value;

use super::{Convert, When};
use crate::commands::train::Bar;
use crate::commands::{Common, Failure};
use crate::convert::{compare, distill};

impl Convert {
    /// Trains a hash grid on renderings of the source, and compares both on held-out views.
    pub(super) fn distill(
        &self,
        (source, about): (&Model<'_>, &About<'_>),
        bytes: u64,
        (own, distance): (&[Camera], f32),
        common: &Common,
    ) -> Result<Value, Failure> {
        let length = Length::Seconds(self.distill_seconds);
        let most = usize::try_from(bytes).unwrap_or(usize::MAX);
        let shading = match self.shading {
            Some(When::PerSample) => Shading::PerSample,
            Some(When::PerRay) => Shading::PerRay,
            None => source.field.decoder().map_or(Shading::PerRay, |decoder| decoder.shading),
        };
        let config = distill::config(source, shading, most, length).ok_or_else(|| {
            format!("--distill-to {bytes}: no model is that small, expected at least 600000")
        })?;
        let [cameras, others] = self.cameras(&source.space, about, own, distance)?;
        let settings = self.rendering.settings(None);
        let say = |line: String| {
            if !common.quiet {
                eprintln!("{line}");
            }
        };
        say(format!("rendering {} views of the source", cameras.len()));
        let dataset = distill::views(source, &cameras, &settings, |done| {
            if done % 20 == 0 {
                say(format!("{done} of {} views", cameras.len()));
            }
        })?;
        let mut trainer = Trainer::with_prepass(dataset, config, self.rendering.vectors.level())?;
        let mut run = Run::new(length, Instant::now());
        let mut bar = Bar::new(common);
        bar.phase("training");
        while let Some(progress) = run.step(&mut trainer)? {
            bar.show(&progress);
        }
        drop(bar);
        let finished = trainer.finished(run.finishing_budget(&trainer))?;
        let model = finished.model();
        let display = Display { background: source.display.srgb_background(), ..model.display };
        let model = Model { display, ..model };
        let precision = self.precision.unwrap_or(Precision::I8);
        let written = pocketnerf_formats::write(&model, about, precision)?;
        if written.len() > most {
            return Err(format!(
                "the distilled model has {} bytes in {precision:?}, more than --distill-to {bytes}: \
                 nothing was written; leave --precision out",
                written.len()
            )
            .into());
        }
        output::write_atomic(&self.out, &written)?;
        let finest = picture::Settings { quality: 1.0, ..settings };
        let models = [(source, Sampling::Occupancy), (&model, Sampling::Occupancy)];
        let difference = serde_json::to_value(compare(models, &others, &finest)?)?;
        let fraction = model.occupancy.map_or(1.0, |cells| cells.fraction());
        let program = about.provenance.map_or("", |provenance| provenance.method);
        Ok(self.report(program, written.len(), fraction, [Value::Null, difference]))
    }

    /// Cameras to train and to compare on: those of a dataset, the source's own, or some all
    /// around.
    fn cameras(
        &self,
        space: &Space,
        about: &About<'_>,
        own: &[Camera],
        distance: f32,
    ) -> Result<[Vec<Camera>; 2], Failure> {
        let Some(folder) = &self.data else {
            return distill::cameras(space, own, distance).ok_or_else(|| {
                "--distill-to: views of a scene that is in no box are those of its capture, give --data"
                    .into()
            });
        };
        let factor = self.downscale_factor;
        let load = |split| self.reading.read(folder, split, factor);
        let of = |dataset: Dataset| {
            let cameras = dataset.views.iter();
            cameras.map(|view| dataset.camera_in_model(&view.camera, &about.scene)).collect()
        };
        Ok([of(load(Split::Train)?), of(load(Split::Test)?)])
    }
}
