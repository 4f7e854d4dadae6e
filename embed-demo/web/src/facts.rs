//! What is known of a model, as numbers in a row.

use pocketnerf_core::{ColorSpace, Space, math};
use pocketnerf_formats::ModelFile;

use crate::scene::to_dataset;

/// How many numbers there are.
pub const LENGTH: usize = 56;

/// What is known of a model. The page reads the same numbers by their places: `info.js`.
/// Coordinates and lengths are the dataset's, unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts(pub [f32; LENGTH]);

impl Facts {
    pub(crate) fn of(file: &ModelFile<'_>) -> Self {
        let (model, scene) = (&file.model, &file.about.scene);
        let (space, own) = (&model.space, file.about.camera);
        let (pose, tangent) = own
            .map_or_else(|| beside(file), |own| (own.camera_to_world, math::tan(0.5 * own.fov_x)));
        let size = own.map_or([800; 2], |own| [own.width, own.height]);
        let mut facts = [0.0; LENGTH];
        let mut at = 0;
        let mut tell = |numbers: &[f32]| {
            facts[at..at + numbers.len()].copy_from_slice(numbers);
            at += numbers.len();
        };
        let flag = |is: bool| f32::from(u8::from(is));
        // 0: the file's own camera, or one beside the scene, and how wide it sees: the tangent
        // of half its angle, from which a page has the same focal length to the bit.
        tell(&to_dataset(scene, &pose));
        tell(&[tangent, size[0] as f32, size[1] as f32, flag(own.is_some())]);
        // 20: the middle of what there is to see, and the longest side of its box.
        tell(&scene.to_dataset(space.center()));
        tell(&[scene.scale / space.unit_map().scale]);
        // 24
        tell(&model.display.background);
        tell(&[flag(model.display.color_space == ColorSpace::Linear)]);
        // 28
        tell(&[
            file.about.quality.unwrap_or(0.5),
            flag(matches!(space, Space::Box { .. })),
            scene.scale * model.sampling.step,
            model.occupancy.map_or(1.0, |occupancy| occupancy.fraction()),
        ]);
        // 32: the box in the model's own coordinates, and the way from these to the dataset's.
        space.bounds().iter().for_each(|corner| tell(corner));
        tell(&[scene.scale]);
        scene.rotation.iter().for_each(|row| tell(row));
        tell(&scene.translation);
        // 51: before a forward-facing capture, how far away its nearest thing is.
        tell(&[near(space) * scene.scale]);
        Self(facts)
    }

    /// The quality that pictures have where nobody chooses.
    #[must_use]
    pub const fn quality(&self) -> f32 {
        self.0[28]
    }
}

fn near(space: &Space) -> f32 {
    match space {
        #[cfg(feature = "ndc")]
        Space::Ndc(ndc) => ndc.near,
        _ => 0.0,
    }
}

/// A pose in the model's coordinates, and the tangent of half the angle that it sees, where the file has none: half a
/// radian above the dataset's x axis; a forward-facing capture from where it was taken.
fn beside(file: &ModelFile<'_>) -> ([f32; 16], f32) {
    let (space, scene) = (&file.model.space, &file.about.scene);
    #[cfg(feature = "ndc")]
    if let Space::Ndc(ndc) = space {
        let pose = pocketnerf_core::Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        return (pose, 1.0 / ndc.slope[0]);
    }
    let (middle, distance) = (space.center(), 2.0 / space.unit_map().scale);
    let [x, z] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| scene.to_model_direction(axis));
    let (sin, cos) = math::sin_cos(0.5);
    let eye = core::array::from_fn(|a| middle[a] + distance * (cos * x[a] + sin * z[a]));
    (pocketnerf_core::Camera::look_at(eye, middle, z), math::tan(0.35))
}
