//! Pictures of baselines.

use pocketnerf_baselines::Renderer;
use pocketnerf_core::Display;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Antialias, Painter};
use serde_json::json;

use super::geometry::Numbers;
use super::path::Place;
use super::{Render, picture_bytes};
use crate::commands::baseline_file::{about, open_baseline, photographs};
use crate::commands::rendering::Sampling;
use crate::commands::stop::Stop;
use crate::commands::{Common, Failure, memory};

impl Render {
    pub(super) fn render_baseline(
        &self,
        bytes: &[u8],
        stop: &Stop,
        common: &Common,
    ) -> Result<(), Failure> {
        let deadline = self.deadline_ms.map(|_| "--deadline-ms");
        let sampling = (self.sampling != Sampling::Occupancy).then_some("--sampling");
        if let Some(option) = self.geometry.option().or(deadline).or(sampling) {
            return Err(format!("{option}: for models alone, and this is a baseline").into());
        }
        let baseline = open_baseline(&self.model, bytes)?;
        let photographs = photographs(baseline.origin());
        let about = about(baseline.origin(), photographs.as_ref());
        let (cameras, fps) = self.cameras(Place { about: &about, space: &baseline.space() })?;
        let bytes_of_picture = picture_bytes(&cameras, Antialias::Off, 0);
        memory::check(bytes_of_picture, "render smaller pictures", || "a picture".to_owned())?;
        let background = self.background.unwrap_or_else(|| baseline.background());
        let display = Display { background, ..Display::default() };
        let work = (bytes, format!("{cameras:?} {display:?}"), env!("CARGO_PKG_VERSION"));
        let mut renderer = Renderer::new(&baseline);
        let seconds = self.pictures((&cameras, fps), &work, stop, common, |camera| {
            let rendered = renderer.paint(camera, &Lens::Pinhole)?;
            Ok((rendered.rgb8(&display), Numbers::default()))
        })?;
        let object = json!({
            "bytes": bytes.len(),
            "method": baseline.method().name(),
            "rays_per_pixel": 1,
            "device": "cpu",
        });
        self.report(&cameras, seconds, object, &[], common);
        Ok(())
    }
}
