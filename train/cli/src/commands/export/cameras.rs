//! Where a surface is looked at from.

use glam::Vec3;
use pocketnerf_core::Camera;
use pocketnerf_formats::{ModelFile, Photographs};
use pocketnerf_train::cameras::sphere;
use pocketnerf_train::dataset::{Split, View, thin};

use super::Export;
use crate::commands::eval::shift;
use crate::commands::{Common, Failure};

/// More cameras tell little more.
const CAMERAS: usize = 100;

impl Export {
    /// Cameras to look from, in the model's coordinates, and the dataset's views, in its own.
    pub(super) fn cameras(
        &self,
        file: &ModelFile<'_>,
        common: &Common,
    ) -> Result<(Vec<Camera>, Vec<View>), Failure> {
        let own = file.about.camera.map(|camera| camera.camera());
        let shifted = |mut camera: Camera| {
            shift(&mut camera, file.about.pixel_origin, 1);
            camera
        };
        let Some(data) = &self.data else {
            if let Some(photographs) = file.about.photographs.filter(|all| !all.is_empty()) {
                return Ok((taken(&photographs, own.as_ref()).map(shifted).collect(), Vec::new()));
            }
            if file.model.space.scene_box().is_none() {
                return Err(format!(
                    "{}: its scene has no box to look at from outside, and it does not say where \
                     photographs were taken; give --data, the dataset whose cameras look at it",
                    self.model.display()
                )
                .into());
            }
            let side = (2 * self.resolution).min(1024);
            return Ok((sphere(&file.model.space, own.as_ref(), CAMERAS, side), Vec::new()));
        };
        let mut dataset = self.reading.load(data, Split::Train, self.downscale_factor, common)?;
        thin(&mut dataset.views, CAMERAS);
        let scene = &file.about.scene;
        let camera = |view: &View| shifted(dataset.camera_in_model(&view.camera, scene));
        Ok((dataset.views.iter().map(camera).collect(), dataset.views))
    }
}

/// The cameras of photographs, with pictures as large as those of the model's own camera.
fn taken(photographs: &Photographs<'_>, own: Option<&Camera>) -> impl Iterator<Item = Camera> {
    let [width, height] = own.map_or([400; 2], |camera| [camera.width, camera.height]);
    let fov_x = 2.0 * (0.5 / photographs.focal).atan();
    photographs.poses().map(move |pose| Camera::from_fov_x(width, height, fov_x, pose))
}

/// The dataset's axis that is nearest to what is up in the model's own camera, or in all cameras.
pub(super) fn up(file: &ModelFile<'_>, cameras: &[Camera]) -> [f32; 3] {
    let own = file.about.camera.map(|camera| camera.camera());
    let mean = own.as_slice().iter().chain(cameras).map(|camera| {
        let pose = file.about.scene.camera_to_dataset(camera).camera_to_world;
        Vec3::new(pose[1], pose[5], pose[9])
    });
    let mean: Vec3 = mean.sum();
    let axis = mean.abs().max_position();
    let mut up = [0.0; 3];
    up[axis] = if mean[axis] < 0.0 { -1.0 } else { 1.0 };
    up
}
