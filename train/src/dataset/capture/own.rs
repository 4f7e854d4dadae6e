//! The coordinates of a dataset's own files.
//!
//! Captures of structure from motion lie anyhow. They are moved, turned and scaled as they are
//! read, so that a scene stands upright in the middle; what users ask and get is in the
//! coordinates of their files all the same.

use pocketnerf_core::Camera;
use pocketnerf_core::query::Similarity;
use pocketnerf_formats::{Scene, World};

use crate::dataset::Dataset;

/// The coordinates of a capture's files, beside those in which it is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Own {
    /// From the coordinates in which the capture is read to those of its files.
    pub similarity: Similarity,
    /// What is up in those of its files, a unit vector.
    pub up: [f32; 3],
}

impl Dataset {
    /// What a model trained on these views says of coordinates: from those in which the dataset is
    /// read to those of its files.
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
    /// model that says nothing of them was trained in those in which the dataset is read.
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

    /// The box, in the coordinates in which the dataset is read, around this one in those of its
    /// files: smallest and largest corner.
    #[must_use]
    pub fn box_as_read(&self, corners: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
        self.scene().box_to_model(corners)
    }
}
