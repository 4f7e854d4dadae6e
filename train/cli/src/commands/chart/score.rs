//! Scores of pictures, kept in files with what they depend on.

use std::path::{Path, PathBuf};

use pocketnerf_baselines::Renderer;
use pocketnerf_core::Camera;
use pocketnerf_train::dataset::{Dataset, hash_of};
use pocketnerf_train::evaluate::{evaluate, evaluate_pictures};
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::output;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::picture::image_file;
use serde::{Deserialize, Serialize};

use super::measure::Way;
use crate::chart::Program;
use crate::chart::rounds::Subject;
use crate::commands::Failure;

/// Most pixels along a side of a point's picture: larger ones are cropped.
const PICTURE: u32 = 400;
/// Brightness of the difference.
const GAIN: u8 = 4;

/// The scores, which do not change from run to run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Scored {
    of: String,
    pub(super) views: usize,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) background: [f32; 3],
    pub(super) psnr: Option<f64>,
    pub(super) psnr_median: Option<f64>,
    pub(super) psnr_p05: Option<f64>,
    pub(super) psnr_min: Option<f64>,
    pub(super) worst_view: Option<String>,
    pub(super) ssim: Option<f64>,
    pub(super) ms_ssim: Option<f64>,
    pub(super) lpips: Option<f64>,
    pub(super) depth_error: Option<f64>,
    pub(super) samples_per_ray: f64,
    pub(super) seconds_per_frame: f64,
    /// Scores of every view, for readers of the file.
    per_view: serde_json::Value,
}

/// What pictures are compared with, and where scores and pictures are kept.
pub(super) struct Judge<'a> {
    pub(super) dataset: &'a Dataset,
    pub(super) background: [f32; 3],
    pub(super) metrics: &'a Metrics,
    pub(super) folders: &'a [PathBuf; 2],
}

impl Judge<'_> {
    /// The way's score and picture, kept or new.
    pub(super) fn score(
        &self,
        way: &Way<'_>,
        subject: Subject<'_>,
    ) -> Result<(Scored, PathBuf), Failure> {
        let [scores, pictures] = self.folders;
        let path = scores.join(format!("{}.json", way.id));
        let picture = pictures.join(format!("{}.png", way.id));
        let of = self.identity(way);
        let kept = std::fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        if let Some(scored) = kept.filter(|scored: &Scored| scored.of == of && picture.is_file()) {
            return Ok((scored, picture));
        }
        let shown = self.dataset.views.len() / 2;
        let mut written = Ok(());
        let (dataset, background) = (self.dataset, self.background);
        let each = |i: usize, ours: &[u8], truth: &[u8]| {
            if i == shown {
                written = write_picture(&picture, &dataset.views[i].camera, ours, truth);
            }
        };
        let result = match subject {
            Subject::Model(model, settings) => {
                evaluate(model, dataset, background, &settings, self.metrics, each)
            }
            Subject::Baseline(baseline) => {
                let mut renderer = Renderer::new(baseline);
                evaluate_pictures(&mut renderer, dataset, background, self.metrics, each)
            }
        }?;
        written?;
        let known = |value: Option<f64>| value.filter(|value| value.is_finite());
        let scored = Scored {
            of,
            views: result.views,
            width: result.width,
            height: result.height,
            background: result.background,
            psnr: known(Some(result.psnr)),
            psnr_median: known(Some(result.psnr_median)),
            psnr_p05: known(Some(result.psnr_p05)),
            psnr_min: known(Some(result.psnr_min)),
            worst_view: result.worst_view,
            ssim: known(result.ssim),
            ms_ssim: known(result.ms_ssim),
            lpips: known(result.lpips),
            depth_error: known(result.depth_error),
            samples_per_ray: result.samples_per_ray,
            seconds_per_frame: result.seconds_per_frame,
            per_view: serde_json::to_value(&result.per_view)?,
        };
        output::write_atomic(&path, &serde_json::to_vec_pretty(&scored)?)?;
        Ok((scored, picture))
    }

    /// Everything that a score depends on.
    fn identity(&self, way: &Way<'_>) -> String {
        let how = way.settings.map(|settings| {
            let Settings { simd, skip, quality, sampling, antialias, .. } = settings;
            format!("{simd:?} {skip} {quality} {sampling:?} {antialias:?}")
        });
        format!(
            "model {:016x}, views {:016x}, on {:?}, {}, LPIPS {:?}, {}",
            hash_of(&way.model.bytes),
            self.dataset.fingerprint(),
            self.background,
            how.unwrap_or_default(),
            self.metrics.lpips.as_ref().map(|lpips| lpips.network()),
            Program::this().commit.unwrap_or_default(),
        )
    }
}

/// Model, truth and difference side by side, cropped to the middle.
fn write_picture(
    path: &Path,
    camera: &Camera,
    ours: &[u8],
    truth: &[u8],
) -> Result<(), output::OutputError> {
    let [width, height] = [camera.width, camera.height].map(|side| side.min(PICTURE));
    let [left, top] = [(camera.width - width) / 2, (camera.height - height) / 2];
    let row = |y: u32| {
        3 * (y * camera.width + left) as usize..3 * (y * camera.width + left + width) as usize
    };
    let middle =
        |rgb: &[u8]| (top..top + height).flat_map(|y| rgb[row(y)].to_vec()).collect::<Vec<u8>>();
    let (ours, truth) = (middle(ours), middle(truth));
    let difference = image_file::difference(&ours, &truth, GAIN);
    let (width, pixels) = image_file::side_by_side(width, &[&ours, &truth, &difference]);
    image_file::write_rgb(path, width, height, &pixels)
}
