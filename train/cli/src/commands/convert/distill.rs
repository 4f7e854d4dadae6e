//! `pocketnerf convert --distill-to`.

use std::time::Instant;

use pocketnerf_core::field::Shading;
use pocketnerf_core::{Camera, Display, Model, Space};
use pocketnerf_formats::{About, Precision};
use pocketnerf_train::convert::VolumeConversion;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::output;
use pocketnerf_train::picture::{self, Painter, Renderer, Sampling};
use pocketnerf_train::trainer::{Length, Run, Trainer};
use serde_json::Value;

use super::{Convert, When, about, cameras_of, default_camera, orbit};
use crate::commands::train::Bar;
use crate::commands::{Common, Failure};
use crate::convert::{compare, distill};

/// Most bytes of a hash grid that learns from what no kind of field holds, unless given.
const LEARNT: u64 = 5_000_000;

/// What a hash grid learns from.
pub(super) struct Source<'s> {
    /// Takes its pictures.
    pub(super) painter: &'s mut dyn Painter,
    pub(super) space: Space,
    pub(super) display: Display,
    /// When it computes colours.
    pub(super) shading: Shading,
    pub(super) about: &'s About<'s>,
    /// The cameras that it was trained with, if it has them.
    pub(super) views: &'s [Camera],
    /// How far they are from what they look at; 0 if unknown.
    pub(super) distance: f32,
}

impl Convert {
    /// Trains a hash grid on renderings of a model, and compares both on held-out views.
    pub(super) fn distill_model(
        &self,
        (model, about): (&Model<'_>, &About<'_>),
        bytes: u64,
        (views, distance): (&[Camera], f32),
        common: &Common,
    ) -> Result<Value, Failure> {
        let sampling = Sampling::Occupancy;
        let given = self.rendering.settings(None);
        let settings = picture::Settings { quality: 1.0, sampling, ..given };
        let decoder = model.field.decoder();
        let source = Source {
            painter: &mut Renderer::new(model, &settings),
            space: model.space,
            display: model.display,
            shading: decoder.map_or(Shading::PerRay, |decoder| decoder.shading),
            about,
            views,
            distance,
        };
        self.distill(source, bytes, common)
    }

    /// Trains a hash grid on pictures of the source, and compares both on held-out views.
    pub(super) fn distill(
        &self,
        source: Source<'_>,
        bytes: u64,
        common: &Common,
    ) -> Result<Value, Failure> {
        let Source { painter, space, display, about, .. } = source;
        let length = Length::Seconds(self.distill_seconds);
        let most = usize::try_from(bytes).unwrap_or(usize::MAX);
        let shading = match self.shading {
            Some(When::PerSample) => Shading::PerSample,
            Some(When::PerRay) => Shading::PerRay,
            None => source.shading,
        };
        let config = distill::config(&space, shading, most, length).ok_or_else(|| {
            format!("--distill-to {bytes}: no model is that small, expected at least 600000")
        })?;
        let [cameras, others] = self.cameras(&space, about, source.views, source.distance)?;
        let say = |line: String| {
            if !common.quiet {
                eprintln!("{line}");
            }
        };
        say(format!("rendering {} views of the source", cameras.len()));
        let dataset = distill::views(painter, (&space, &display), &cameras, |done| {
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
        let background = display.srgb_background();
        let model = Model { display: Display { background, ..model.display }, ..model };
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
        let sampling = Sampling::Occupancy;
        let given = self.rendering.settings(None);
        let finest = picture::Settings { quality: 1.0, sampling, ..given };
        let mut renderer = Renderer::new(&model, &finest);
        let both: [(&mut dyn Painter, _); 2] =
            [(painter, display.color_space), (&mut renderer, model.display.color_space)];
        let difference = serde_json::to_value(compare(both, background, &others)?)?;
        let fraction = model.occupancy.map_or(1.0, |cells| cells.fraction());
        let program = about.provenance.map_or("", |provenance| provenance.method);
        Ok(self.report(program, written.len(), fraction, [Value::Null, difference]))
    }

    /// Trains a hash grid on pictures of what no kind of field holds.
    pub(super) fn learn(
        &self,
        volume: &VolumeConversion,
        dataset: Option<&Dataset>,
        common: &Common,
    ) -> Result<Value, Failure> {
        let program = volume.program();
        let found = format!("a model of {program}");
        self.refuse(&found, &self.of_networks())?;
        let more = [("--near", self.near.is_some()), ("--aabb", self.aabb.is_some())];
        self.refuse(&found, &more)?;
        if !common.quiet {
            eprintln!(
                "note: {program}: a hash grid learns from its pictures; --distill-to and \
                 --distill-seconds say how large it is and how long that takes"
            );
        }
        let scene = volume.scene();
        let views = dataset.map_or_else(Vec::new, |dataset| cameras_of(dataset, &scene));
        let first = views.first().copied();
        let camera = first.unwrap_or_else(|| orbit(volume.space(), 0.0, [0.0, 0.0, 1.0])[0]);
        let source = Source {
            painter: &mut volume.painter(),
            space: *volume.space(),
            display: volume.display(),
            shading: Shading::PerRay,
            about: &about(default_camera(&camera), scene, program),
            views: &[],
            distance: 0.0,
        };
        self.distill(source, self.distill_to.unwrap_or(LEARNT), common)
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
        let of = |dataset: Dataset| cameras_of(&dataset, &about.scene);
        Ok([of(load(Split::Train)?), of(load(Split::Test)?)])
    }
}
