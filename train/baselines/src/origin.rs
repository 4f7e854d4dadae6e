//! Where a baseline comes from.

use pocketnerf_core::Camera;
use pocketnerf_train::dataset::Dataset;
use serde::{Deserialize, Serialize};

/// What a baseline was trained on, and its cameras.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// The dataset's name.
    pub dataset: String,
    /// The dataset's fingerprint: see [`Dataset::fingerprint`].
    pub fingerprint: u64,
    /// Random seed.
    pub seed: u64,
    /// By how much its images were downscaled along each side.
    pub downscale_factor: u32,
    /// Picture size of the first camera, pixels.
    pub size: [u32; 2],
    /// Its focal lengths, pixels.
    pub focal: [f32; 2],
    /// Camera-to-world matrices of all photographs, row after row, scene units.
    pub poses: Vec<[f32; 16]>,
    /// From scene units to the dataset's: scale, rotation (row after row) and translation.
    pub to_dataset: (f32, [[f32; 3]; 3], [f32; 3]),
}

impl Origin {
    /// Of a training split whose images were downscaled.
    #[must_use]
    pub fn of(dataset: &Dataset, seed: u64, downscale_factor: u32) -> Self {
        let first = dataset.views.first().map(|view| view.camera);
        let scene = dataset.scene();
        Self {
            dataset: dataset.name(),
            fingerprint: dataset.fingerprint(),
            seed,
            downscale_factor,
            size: first.map_or([1; 2], |camera| [camera.width, camera.height]),
            focal: first.map_or([1.0; 2], |camera| camera.focal),
            poses: dataset.views.iter().map(|view| view.camera.camera_to_world).collect(),
            to_dataset: (scene.scale, scene.rotation, scene.translation),
        }
    }

    /// The camera of the first photograph, with its principal point in the middle.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let [width, height] = self.size;
        let center = [0.5 * width as f32, 0.5 * height as f32];
        let identity = || {
            let mut pose = [0.0; 16];
            [0, 5, 10, 15].into_iter().for_each(|i| pose[i] = 1.0);
            pose
        };
        let camera_to_world = self.poses.first().copied().unwrap_or_else(identity);
        Camera { width, height, focal: self.focal, center, camera_to_world }
    }

    pub(crate) fn is_sound(&self) -> bool {
        let poses = self.poses.iter().all(|camera_to_world| {
            Camera { camera_to_world: *camera_to_world, ..self.camera() }.validate().is_ok()
        });
        let (scale, rotation, translation) = &self.to_dataset;
        let numbers = rotation.iter().flatten().chain(translation);
        poses && *scale > 0.0 && scale.is_finite() && numbers.into_iter().all(|v| v.is_finite())
    }
}
