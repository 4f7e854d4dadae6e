//! What a file holds besides the model: coordinates, an initial camera, and how the
//! model was made.

use pocketnerf_core::Camera;
use pocketnerf_core::query::Similarity;

use crate::photographs::Photographs;

/// Everything in a file that is not the model itself.
///
/// By default, model coordinates are dataset coordinates; there is no camera, and the
/// origin is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct About<'a> {
    /// Dataset coordinates and a name.
    pub scene: Scene<'a>,
    /// The initial view.
    pub camera: Option<DefaultCamera>,
    /// How the model was made.
    pub provenance: Option<Provenance<'a>>,
    /// The point of a pixel through which training rays passed. Only read with the feature
    /// `alloc`.
    pub pixel_origin: PixelOrigin,
    /// The default quality of renderings, from 0 (fastest) to 1 (exact), as in
    /// [`Model::detail`](pocketnerf_core::Model::detail); `None`: 0.5. Only read with the
    /// feature `alloc`.
    pub quality: Option<f32>,
    /// Where the photographs were taken. Only read with the feature `std`.
    pub photographs: Option<Photographs<'a>>,
    /// What is known of the dataset's coordinates. Only read with the feature `alloc`.
    pub world: World,
}

/// What is known of a dataset's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct World {
    /// What is up there, a unit vector.
    pub up: Option<[f32; 3]>,
    /// Metres per dataset unit, greater than 0.
    pub metres: Option<f32>,
}

impl World {
    /// What is up there: +z where nobody says.
    #[must_use]
    pub fn up(&self) -> [f32; 3] {
        self.up.unwrap_or([0.0, 0.0, 1.0])
    }
}

/// The point of a pixel through which its ray passes. A model trained with corners is
/// rendered half a pixel off when rays pass through centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelOrigin {
    /// Its centre, as everywhere in this crate.
    #[default]
    Center,
    /// Its upper left corner, as in the original NeRF and most programs derived from it.
    Corner,
}

/// The similarity transform from the model's coordinates (scene units) to the
/// dataset's: `dataset = scale * rotation * model + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<'a> {
    /// Dataset units per scene unit, greater than 0.
    pub scale: f32,
    /// A proper rotation, row after row.
    pub rotation: [[f32; 3]; 3],
    /// Dataset coordinates of the model's origin, dataset units.
    pub translation: [f32; 3],
    /// The scene's name; no control characters.
    pub name: Option<&'a str>,
}

impl Default for Scene<'_> {
    fn default() -> Self {
        Self {
            scale: 1.0,
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.0; 3],
            name: None,
        }
    }
}

impl From<Similarity> for Scene<'_> {
    /// Without a name.
    fn from(Similarity { scale, rotation, translation }: Similarity) -> Self {
        Self { scale, rotation, translation, name: None }
    }
}

impl Scene<'_> {
    /// The transform without the name.
    #[must_use]
    pub const fn similarity(&self) -> Similarity {
        let Self { scale, rotation, translation, .. } = *self;
        Similarity { scale, rotation, translation }
    }

    /// A point in scene units to dataset coordinates.
    #[must_use]
    pub fn to_dataset(&self, p: [f32; 3]) -> [f32; 3] {
        self.similarity().to_dataset(p)
    }

    /// A direction in dataset coordinates as one in the model's, of the same length.
    #[must_use]
    pub fn to_model_direction(&self, d: [f32; 3]) -> [f32; 3] {
        self.similarity().to_model_direction(d)
    }

    /// A camera in dataset coordinates as one in scene units.
    #[must_use]
    pub fn camera_to_model(&self, camera: &Camera) -> Camera {
        let c2w = &camera.camera_to_world;
        let mut model = *camera;
        let mut set = |column: usize, values: [f32; 3]| {
            (0..3).for_each(|row| model.camera_to_world[4 * row + column] = values[row]);
        };
        for column in 0..3 {
            set(column, self.to_model_direction([0, 4, 8].map(|row| c2w[row + column])));
        }
        set(3, self.to_model(camera.position()));
        model
    }

    /// A camera in scene units as one in dataset coordinates.
    #[must_use]
    pub fn camera_to_dataset(&self, camera: &Camera) -> Camera {
        let (from, position) = (&camera.camera_to_world, self.to_dataset(camera.position()));
        let mut dataset = *camera;
        for (row, turn) in self.rotation.iter().enumerate() {
            let to = &mut dataset.camera_to_world[4 * row..];
            for column in 0..3 {
                to[column] = (0..3).map(|i| turn[i] * from[4 * i + column]).sum();
            }
            to[3] = position[row];
        }
        dataset
    }

    /// A point in dataset coordinates to scene units.
    #[must_use]
    pub fn to_model(&self, p: [f32; 3]) -> [f32; 3] {
        self.similarity().to_model(p)
    }

    /// The box in scene units around one in dataset coordinates: smallest and largest corner.
    #[must_use]
    pub fn box_to_model(&self, corners: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
        let corner = |i: usize| self.to_model([0, 1, 2].map(|axis| corners[i >> axis & 1][axis]));
        let nothing = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        (0..8).map(corner).fold(nothing, |[low, high], p| {
            [[0, 1, 2].map(|a| low[a].min(p[a])), [0, 1, 2].map(|a| high[a].max(p[a]))]
        })
    }
}

/// A camera that shows the model well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefaultCamera {
    /// 4×4 camera-to-world as in [`Camera::camera_to_world`], scene units.
    pub camera_to_world: [f32; 16],
    /// Horizontal field of view in radians, between 0 and π.
    pub fov_x: f32,
    /// Suggested picture width, pixels, 1 to [`MAX_PICTURE_SIDE`].
    pub width: u32,
    /// Suggested picture height, pixels, 1 to [`MAX_PICTURE_SIDE`].
    pub height: u32,
}

/// The largest side of a suggested picture: no file asks for more memory than
/// such a picture takes.
pub const MAX_PICTURE_SIDE: u32 = Camera::MAX_SIDE;

impl DefaultCamera {
    /// The camera in core's terms.
    #[must_use]
    pub fn camera(&self) -> Camera {
        Camera::from_fov_x(self.width, self.height, self.fov_x, self.camera_to_world)
    }
}

/// How a model was made. Holds no dates, durations, machines or paths: the same
/// training gives the same bytes. Texts hold no control characters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Provenance<'a> {
    /// Name and version of the program that wrote the file.
    pub program: &'a str,
    /// Name of the training method, or of the conversion.
    pub method: &'a str,
    /// Seed of the training's random numbers.
    pub seed: u64,
    /// Optimizer steps.
    pub steps: u64,
    /// Fingerprint of the training images and cameras.
    pub trained_on: u64,
    /// Name of the dataset.
    pub dataset: &'a str,
    /// PSNR over the training rays at the end, dB.
    pub train_psnr: Option<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dataset_and_model_coordinates() {
        // A quarter turn about z, twice as large, moved.
        let scene = Scene {
            scale: 2.0,
            rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [10.0, 20.0, 30.0],
            name: None,
        };
        assert_eq!(scene.to_dataset([1.0, 2.0, 3.0]), [6.0, 22.0, 36.0]);
        assert_eq!(scene.to_model([6.0, 22.0, 36.0]), [1.0, 2.0, 3.0]);
        assert_eq!(Scene::default().to_dataset([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        // A camera sees the same, whichever coordinates it is in.
        let eye = scene.to_dataset([3.0, 1.0, 2.0]);
        let target = scene.to_dataset([0.5, 0.25, 0.0]);
        let pose = Camera::look_at(eye, target, [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(40, 30, 1.0, pose);
        let model = scene.camera_to_model(&camera);
        let close = |a: &[f32], b: &[f32]| {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
        };
        close(&model.position(), &[3.0, 1.0, 2.0]);
        let back = scene.camera_to_dataset(&model);
        close(&back.camera_to_world, &camera.camera_to_world);
        let p = [0.25, 0.5, -0.75];
        let [seen, expected] = [model.project(p), camera.project(scene.to_dataset(p))];
        close(&seen.unwrap(), &expected.unwrap());
    }
}
