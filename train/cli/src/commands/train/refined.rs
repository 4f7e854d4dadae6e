//! What became of the poses of a run that refines them.

use pocketnerf_train::trainer::Trainer;
use serde_json::{Value, json};

use super::Origin;

/// Corrections beyond these, degrees and shares of the cameras' distance, are doubted: structure
/// from motion errs by tenths of a degree, and by this much where it has failed.
const MOST: [f32; 2] = [5.0, 0.1];

/// The corrections of all photographs.
pub(super) struct Refined<'o> {
    trainer: &'o Trainer,
    origin: &'o Origin,
    /// Degrees, and shares of the cameras' distance.
    sizes: Vec<[f32; 2]>,
}

impl<'o> Refined<'o> {
    /// `None` where poses are not refined.
    pub(super) fn of(trainer: &'o Trainer, origin: &'o Origin) -> Option<Self> {
        trainer.pose_corrections().map(|sizes| Self { trainer, origin, sizes })
    }

    /// Mean and largest.
    fn summary(&self, which: usize) -> Value {
        let sizes = || self.sizes.iter().map(|size| f64::from(size[which]));
        let mean = sizes().sum::<f64>() / self.sizes.len().max(1) as f64;
        json!({ "mean": mean, "max": sizes().fold(0.0, f64::max) })
    }

    /// Adds them to what `train --json` prints.
    pub(super) fn add_to(&self, result: &mut Value) {
        result["pose_corrections_degrees"] = self.summary(0);
        result["pose_corrections_shift"] = self.summary(1);
        let cameras = self.trainer.cameras().iter().enumerate().map(|(view, camera)| {
            let camera = self.origin.camera_in_files(camera);
            let rows: Vec<&[f32]> = camera.camera_to_world.chunks(4).collect();
            json!({ "view": self.origin.view(view), "camera_to_world": rows })
        });
        result["refined_cameras"] = cameras.collect();
    }

    /// A line for the user where a correction is more than is plausible.
    pub(super) fn doubt(&self) -> Option<String> {
        let beyond = |size: &[f32; 2]| (size[0] / MOST[0]).max(size[1] / MOST[1]);
        let doubtful = self.sizes.iter().filter(|size| beyond(size) > 1.0).count();
        let sizes = self.sizes.iter().enumerate();
        let (view, [degrees, share]) = sizes.max_by(|a, b| beyond(a.1).total_cmp(&beyond(b.1)))?;
        (doubtful > 0).then(|| {
            format!(
                "{}: its camera was turned by {degrees:.1} degrees and moved by {:.1} % of its \
                 distance, expected at most {} and {:.0} ({doubtful} such photographs): their poses \
                 are guesses; leave them out or find the poses anew",
                self.origin.view(view),
                100.0 * share,
                MOST[0],
                100.0 * MOST[1]
            )
        })
    }
}
