//! The coordinates of a dataset's own files.
//!
//! Structure from motion leaves a capture anywhere, at any angle and at any scale. The loader
//! moves, turns and scales it, so that the scene stands upright around the origin. Users still give
//! and get coordinates as their files have them.

use pocketnerf_core::Camera;
use pocketnerf_core::query::Similarity;
use pocketnerf_formats::{Scene, World};

use crate::dataset::Dataset;

/// How to get from the loader's coordinates back to those of the capture's files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Own {
    /// From the loader's coordinates to those of the files.
    pub similarity: Similarity,
    /// Which way is up in the files' coordinates, a unit vector.
    pub up: [f32; 3],
}

impl Dataset {
    /// The transform that a model trained on these views stores: from the loader's coordinates,
    /// which are the model's, to those of the files.
    #[must_use]
    pub fn scene(&self) -> Scene<'static> {
        self.own.map_or_else(Scene::default, |own| own.similarity.into())
    }

    /// What is known of the coordinates of its files.
    #[must_use]
    pub fn world(&self) -> World {
        World { up: self.own.map(|own| own.up), metres: self.metres }
    }

    /// A camera of one of the views in the coordinates of the dataset's files.
    #[must_use]
    pub fn camera_in_files(&self, camera: &Camera) -> Camera {
        self.own.map_or(*camera, |own| Scene::from(own.similarity).camera_to_dataset(camera))
    }

    /// A camera of one of the views in the coordinates of a model whose file has this scene. A
    /// model without a transform of its own is taken to be in the loader's coordinates.
    #[must_use]
    pub fn camera_in_model(&self, camera: &Camera, scene: &Scene<'_>) -> Camera {
        match self.own {
            Some(Own { similarity, .. })
                if [similarity, Similarity::IDENTITY].contains(&scene.similarity()) =>
            {
                *camera
            }
            _ => scene.camera_to_model(&self.camera_in_files(camera)),
        }
    }

    /// The box in the loader's coordinates around one in those of the files: smallest and largest
    /// corner.
    #[must_use]
    pub fn box_as_read(&self, corners: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
        self.scene().box_to_model(corners)
    }
}
