//! Facts about a model, as an array of numbers.

use pocketnerf_core::{ColorSpace, Space, math};
use pocketnerf_formats::ModelFile;

/// Length of the array.
pub const LENGTH: usize = 56;

/// Facts about a model, read by their indices in `instance.js`. Coordinates and lengths are
/// the dataset's unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts(pub [f32; LENGTH]);

impl Facts {
    pub(crate) fn of(file: &ModelFile<'_>) -> Self {
        let (model, scene) = (&file.model, &file.about.scene);
        let (space, own) = (&model.space, file.about.camera);
        let size = own.map_or([800; 2], |own| [own.width, own.height]);
        let view = scene.camera_to_dataset(&file.camera(size[0], size[1]));
        let seen = 0.5 * size[0] as f32 / view.focal[0];
        let tangent = own.map_or(seen, |own| math::tan(0.5 * own.fov_x));
        let mut facts = [0.0; LENGTH];
        let mut at = 0;
        let mut push = |numbers: &[f32]| {
            facts[at..at + numbers.len()].copy_from_slice(numbers);
            at += numbers.len();
        };
        let flag = |is: bool| f32::from(u8::from(is));
        // 0: the file's own camera, or one beside the scene, and the tangent of half its field
        // of view, from which the page computes the same focal length to the bit.
        push(&view.camera_to_world);
        push(&[tangent, size[0] as f32, size[1] as f32, flag(own.is_some())]);
        // 20: the centre of the scene, and the longest side of its box.
        let ([min, max], unit) = extent(space);
        push(&scene.to_dataset(space.center()));
        push(&[scene.scale * (0..3).map(|a| max[a] - min[a]).fold(0.0, f32::max)]);
        // 24
        push(&model.display.background);
        push(&[flag(model.display.color_space == ColorSpace::Linear)]);
        // 28
        push(&[
            file.about.quality.unwrap_or(0.5),
            flag(matches!(space, Space::Box { .. })),
            scene.scale * unit * model.sampling.step,
            model.occupancy.map_or(1.0, |occupancy| occupancy.fraction()),
        ]);
        // 32: the box in the model's coordinates, and the transform to the dataset's.
        [min, max].iter().for_each(|corner| push(corner));
        push(&[scene.scale]);
        scene.rotation.iter().for_each(|row| push(row));
        push(&scene.translation);
        // 51: forward-facing captures: the distance of the nearest object.
        push(&[near(space) * scene.scale]);
        // 52: what is up.
        push(&file.about.world.up());
        Self(facts)
    }

    /// The default quality of pictures.
    #[must_use]
    pub const fn quality(&self) -> f32 {
        self.0[28]
    }
}

/// The box of a space, and its unit of length in scene units. That of contracted space, which has
/// no end, is the cube that keeps its shape.
fn extent(space: &Space) -> ([[f32; 3]; 2], f32) {
    if !space.is_bent() {
        return (space.bounds(), 1.0);
    }
    let (center, radius) = (space.center(), space.viewing_distance());
    ([center.map(|c| c - radius), center.map(|c| c + radius)], radius)
}

fn near(space: &Space) -> f32 {
    match space {
        #[cfg(feature = "ndc")]
        Space::Ndc(ndc) => ndc.near,
        _ => 0.0,
    }
}
