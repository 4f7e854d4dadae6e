//! A point of the chart: one model, rendered one way.

use serde::{Deserialize, Serialize};

/// Name of this program among points.
pub const OURS: &str = "pocketnerf";

/// One model of one scene, rendered one way: a row of `points.csv`, an object of
/// `points.json`. What is unknown is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Point {
    /// Its name, also that of its pictures.
    pub id: String,
    /// `pocketnerf`, or the other program.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// What was trained: `hash-grid`, `nerf`; or the name that another program gives.
    pub method: String,
    /// Name of the model, or of another program's setting.
    pub model: String,
    /// The format of tables: `i8`, `f16`, `f32`.
    pub precision: Option<String>,
    /// `--quality`.
    pub quality: Option<f32>,
    /// `--sampling`.
    pub sampling: Option<String>,
    /// Which views.
    pub split: String,
    /// How many of them.
    pub views: Option<usize>,
    /// Picture width.
    pub width: u32,
    /// Picture height.
    pub height: u32,
    /// The background of pictures and truth: R,G,B from 0 to 1.
    pub background: String,
    /// Random seed of training.
    pub seed: Option<u64>,
    /// The commit of the program that trained it, which may be older than the chart.
    pub train_commit: Option<String>,
    /// Wall time of training, from the start of the program to the written file.
    pub train_seconds: Option<f64>,
    /// Steps of training.
    pub train_steps: Option<u64>,
    /// Peak memory of training.
    pub train_memory_bytes: Option<u64>,
    /// Size of the model file.
    pub bytes: Option<u64>,
    /// Mean of the views' PSNR, dB.
    pub psnr: Option<f64>,
    /// Median of the views' PSNR.
    pub psnr_median: Option<f64>,
    /// Their 5th percentile.
    pub psnr_p05: Option<f64>,
    /// The worst view's PSNR.
    pub psnr_min: Option<f64>,
    /// The name of that view.
    pub worst_view: Option<String>,
    /// Mean of the views' SSIM.
    pub ssim: Option<f64>,
    /// Mean of the views' MS-SSIM.
    pub ms_ssim: Option<f64>,
    /// Mean of the views' LPIPS.
    pub lpips: Option<f64>,
    /// Mean of the views' depth errors, scene units.
    pub depth_error: Option<f64>,
    /// Median time of a picture over the rounds, by the clock, on the machine as it was.
    pub ms_per_frame: Option<f64>,
    /// Lower end of its 95 % bootstrap interval.
    pub ms_low: Option<f64>,
    /// Upper end.
    pub ms_high: Option<f64>,
    /// From the first to the third quartile of the rounds, as a share of the median.
    pub spread: Option<f64>,
    /// Whether the spread exceeds [`UNSTEADY`](Self::UNSTEADY): do not trust the time.
    pub unsteady: Option<bool>,
    /// The median on an undisturbed machine:
    /// [`Turn::normalized_ms`](super::rounds::Turn::normalized_ms).
    pub normalized_ms_per_frame: Option<f64>,
    /// Pictures per second, by the clock.
    pub frames_per_second: Option<f64>,
    /// Pixels per second, by the clock, interpolated ones included.
    pub rays_per_second: Option<f64>,
    /// Evaluations of the field per pixel.
    pub samples_per_ray: Option<f64>,
    /// What rendering needs beside the file and the picture: tables and every thread's
    /// scratch.
    pub render_memory_bytes: Option<u64>,
    /// Threads that rendered.
    pub threads: Option<usize>,
    /// Whether it lies on the frontier of PSNR and time per picture.
    pub frontier: bool,
    /// The command that trains the model.
    pub train_command: Option<String>,
    /// The command that measures it.
    pub eval_command: Option<String>,
    /// Where another program's figures come from.
    pub source: Option<String>,
    /// The machine they were measured on.
    pub machine: Option<String>,
}

impl Point {
    /// A spread above this share of the median is flagged.
    pub const UNSTEADY: f64 = 0.10;

    /// The points that it is compared with: pictures of one scene and size.
    #[must_use]
    pub fn group(&self) -> Group<'_> {
        Group { scene: &self.scene, width: self.width, height: self.height }
    }

    /// Whether it was measured here.
    #[must_use]
    pub fn is_ours(&self) -> bool {
        self.program == OURS
    }

    /// Its series: the method, or the other program.
    #[must_use]
    pub fn series(&self) -> &str {
        if self.is_ours() { &self.method } else { &self.program }
    }
}

/// Pictures of one scene and size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Group<'p> {
    /// The scene's name.
    pub scene: &'p str,
    /// Picture width.
    pub width: u32,
    /// Picture height.
    pub height: u32,
}

impl std::fmt::Display for Group<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}x{}", self.scene, self.width, self.height)
    }
}

/// The groups of points, each once, in order.
#[must_use]
pub fn groups(points: &[Point]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for point in points {
        if !groups.contains(&point.group()) {
            groups.push(point.group());
        }
    }
    groups
}
