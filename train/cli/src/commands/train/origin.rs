//! What is written of where a model comes from.

use pocketnerf_core::Camera;
use pocketnerf_formats::{
    About, DefaultCamera, PhotographList, Precision, Provenance, Scene, World,
};
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::trainer::checkpoint::TrainedOn;
use pocketnerf_train::trainer::{Run, Trainer};

/// Where a model comes from.
pub(in crate::commands) struct Origin {
    name: String,
    /// Of each training view.
    names: Vec<String>,
    camera: Option<DefaultCamera>,
    photographs: Option<PhotographList>,
    scene: Scene<'static>,
    world: World,
    pub(super) trained_on: TrainedOn,
    /// The format of the weights in the model file.
    pub(super) precision: Precision,
}

impl Origin {
    pub(in crate::commands) fn new(
        dataset: &Dataset,
        downscale_factor: u32,
        precision: Precision,
        world: World,
    ) -> Self {
        let cameras: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
        Self {
            name: dataset.name(),
            names: dataset.views.iter().map(|view| view.name.clone()).collect(),
            camera: dataset.views.first().map(|view| default_camera(&view.camera)),
            photographs: PhotographList::new(&cameras),
            scene: dataset.scene(),
            world,
            trained_on: TrainedOn { fingerprint: dataset.fingerprint(), downscale_factor },
            precision,
        }
    }

    /// A camera of a training view in the coordinates of the dataset's files.
    pub(super) fn camera_in_files(&self, camera: &Camera) -> Camera {
        self.scene.camera_to_dataset(camera)
    }

    /// The name of a training view.
    pub(super) fn view(&self, number: usize) -> String {
        self.names.get(number).cloned().unwrap_or_else(|| format!("view {number}"))
    }

    pub(super) fn about(&self, trainer: &Trainer, run: &Run) -> About<'_> {
        About {
            camera: self.camera,
            photographs: self.photographs.as_ref().map(PhotographList::view),
            scene: self.scene,
            world: self.world,
            provenance: Some(Provenance {
                program: concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
                method: method(trainer),
                seed: trainer.config().seed,
                steps: u64::from(trainer.steps()),
                trained_on: self.trained_on.fingerprint,
                dataset: &self.name,
                train_psnr: Some(run.summary(trainer).train_psnr as f32),
            }),
            ..About::default()
        }
    }
}

/// The first training camera: where a viewer may start.
pub(in crate::commands) fn default_camera(camera: &Camera) -> DefaultCamera {
    DefaultCamera {
        camera_to_world: camera.camera_to_world,
        fov_x: 2.0 * (0.5 * camera.width as f32 / camera.focal[0]).atan(),
        width: camera.width,
        height: camera.height,
    }
}

/// The kind of field that was trained.
pub(super) fn method(trainer: &Trainer) -> &'static str {
    trainer.model().field.kind()
}
