//! Comparison of baselines.

use pocketnerf_baselines::Renderer;
use pocketnerf_train::evaluate::evaluate_pictures;
use pocketnerf_train::metrics::Metrics;

use super::pictures::Pictures;
use super::{Eval, Sampling};
use crate::commands::baseline_file::open_baseline;
use crate::commands::{Common, Failure};

impl Eval {
    pub(super) fn compare_baseline(
        &self,
        bytes: &[u8],
        metrics: &Metrics,
        common: &Common,
    ) -> Result<(), Failure> {
        if self.sampling != Sampling::Occupancy {
            return Err("--sampling: for models alone, and this is a baseline".into());
        }
        let baseline = open_baseline(&self.model, bytes)?;
        let dataset = self.reading.load(&self.data, self.split, self.downscale_factor, common)?;
        let mut warnings = dataset.notes.clone();
        let origin = baseline.origin();
        let warning = self.doubt_of_scene(
            origin.dataset == dataset.name(),
            &origin.dataset,
            origin.fingerprint,
        );
        if let Some(warning) = warning {
            common.warn(&warning);
            warnings.push(warning);
        }
        let background = self.background.unwrap_or_else(|| baseline.background());
        let mut pictures = Pictures::new(self.out.as_deref())?;
        let mut renderer = Renderer::new(&baseline);
        let views = &dataset.views;
        let result =
            evaluate_pictures(&mut renderer, &dataset, background, metrics, |i, ours, truth| {
                pictures.add(i, &views[i].camera, ours, truth);
            })?;
        pictures.finish(&result.per_view)?;
        let what = (bytes.len(), baseline.method().name(), "cpu");
        self.report(&result, what, metrics, &warnings, common)
    }
}
