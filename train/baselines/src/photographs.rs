//! What baselines learn from: photographs over a known background.

use glam::Vec3;
use pocketnerf_core::{Camera, Ray};
use pocketnerf_train::dataset::{Dataset, View};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::metrics::{composite_on, quantize_all};
use pocketnerf_train::random::Random;
use pocketnerf_train::trainer::{Backdrop, RaySource, VisualHull, find_box};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{BaselineError, Method};

/// Nothing lies nearer than this share of the mean distance of the cameras from the scene.
const NEAREST: f32 = 0.05;
/// How far forward-facing captures reach where the dataset does not say: in scene units, of which
/// one is the distance of the nearest content.
const FORWARD: [f32; 2] = [1.0, 20.0];

/// Where a scene is, and before which background.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The middle of what is seen, scene units.
    pub(crate) center: [f32; 3],
    /// Half of the side of a cube around it.
    pub(crate) half: f32,
    /// Distances from cameras between which the scene lies.
    pub(crate) depths: [f32; 2],
    /// What lies behind it, sRGB.
    pub(crate) background: [f32; 3],
}

/// One photograph.
#[derive(Clone, Debug)]
pub(crate) struct Photograph {
    pub(crate) camera: Camera,
    pub(crate) lens: Lens,
    /// RGB over the background, three bytes a pixel.
    pub(crate) rgb: Vec<u8>,
    /// A byte a pixel, 0 where it does not count; `None`: all count.
    mask: Option<Vec<u8>>,
}

/// All photographs of a scene.
#[derive(Clone, Debug)]
pub struct Photographs {
    pub(crate) all: Vec<Photograph>,
    pub(crate) place: Place,
    /// Whether the background is known: the images are cut-outs, or their edges are of one colour.
    is_background_known: bool,
}

/// Rays and the colours that they are to have.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    pub(crate) rays: Vec<Ray>,
    /// sRGB, 0 to 1.
    pub(crate) colors: Vec<[f32; 3]>,
}

impl Photographs {
    /// Takes a dataset's photographs, over `background` where they are cut out; white, if nothing
    /// else is known. Where the scene is, the dataset or its silhouettes say.
    ///
    /// # Errors
    /// Where there are none.
    pub fn new(dataset: Dataset, background: Option<[f32; 3]>) -> Result<Self, BaselineError> {
        Self::cut_out(dataset, background, |dataset| {
            let background = background.or(dataset.background).unwrap_or([1.0; 3]);
            place(dataset, background)
        })
    }

    /// The same for a scene of which is known where it is.
    ///
    /// # Errors
    /// Where there are none.
    pub fn at(dataset: Dataset, known: Place) -> Result<Self, BaselineError> {
        Self::cut_out(dataset, Some(known.background), |_| known)
    }

    /// Nothing lies nearer to a camera, or farther away, scene units.
    #[must_use]
    pub fn between(mut self, near: Option<f32>, far: Option<f32>) -> Self {
        let [nearest, farthest] = self.place.depths;
        let near = near.filter(|near| *near > 0.0).unwrap_or(nearest);
        let far = far.unwrap_or(farthest.max(2.0 * near));
        self.place.depths = [near.min(0.99 * far), far];
        self
    }

    fn cut_out(
        mut dataset: Dataset,
        background: Option<[f32; 3]>,
        place: impl Fn(&Dataset) -> Place,
    ) -> Result<Self, BaselineError> {
        if dataset.views.is_empty() {
            return Err(BaselineError::NoPhotographs);
        }
        let is_background_known = dataset.has_alpha || dataset.cut_out(background).is_some();
        let place = place(&dataset);
        let photograph = |view: View| Photograph {
            camera: view.camera,
            lens: view.lens,
            rgb: match view.behind {
                // What was cut out shows its own background.
                Some(_) => {
                    let pixels = view.rgba.as_chunks::<4>().0;
                    pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()
                }
                None => quantize_all(&composite_on(&view.rgba, place.background)),
            },
            mask: view.mask,
        };
        let all = dataset.views.into_par_iter().map(photograph).collect();
        Ok(Self { all, place, is_background_known })
    }

    /// Why a method cannot learn from these, if it cannot.
    #[must_use]
    pub fn refusal(&self, method: Method) -> Option<BaselineError> {
        let (found, least) = (self.all.len(), 2);
        match method {
            Method::Llff if found < least => Some(BaselineError::TooFew { found, least }),
            Method::NeuralVolumes if !self.is_background_known => {
                Some(BaselineError::UnknownBackground)
            }
            _ => None,
        }
    }

    /// `n` random pixels of all photographs, by their rays.
    pub(crate) fn batch(&self, n: usize, seed: u64, step: u32) -> Batch {
        let mut batch = Batch::default();
        for i in 0..n {
            let mut random = Random::new(seed, [BATCH, step.into(), i as u64]);
            let photograph = &self.all[random.below(self.all.len())];
            let (ray, color) = photograph.pixel(&mut random);
            batch.rays.push(ray);
            batch.colors.push(color);
        }
        batch
    }
}

/// The purpose of these random numbers.
const BATCH: u64 = 12;
/// How often a pixel that counts is looked for.
const TRIES: usize = 64;

impl Photograph {
    /// All of one colour.
    #[cfg(test)]
    pub(crate) fn plain(camera: Camera, rgb: [u8; 3]) -> Self {
        let pixels = camera.width as usize * camera.height as usize;
        Self { camera, lens: Lens::Pinhole, rgb: rgb.repeat(pixels), mask: None }
    }

    pub(crate) fn counts(&self, pixel: usize) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask[pixel] != 0)
    }

    /// A random pixel that counts: its ray and its colour.
    fn pixel(&self, random: &mut Random) -> (Ray, [f32; 3]) {
        let Camera { width, height, .. } = self.camera;
        let n = width as usize * height as usize;
        let mut pixel = random.below(n);
        for _ in 0..TRIES {
            if self.counts(pixel) {
                break;
            }
            pixel = random.below(n);
        }
        let (x, y) = (pixel % width as usize, pixel / width as usize);
        let ray = self.lens.ray(&self.camera, x as f32 + 0.5, y as f32 + 0.5);
        (ray, self.color(pixel))
    }

    /// sRGB, 0 to 1.
    pub(crate) fn color(&self, pixel: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| f32::from(self.rgb[3 * pixel + c]) / 255.0)
    }
}

/// Where the scene of these photographs is.
fn place(dataset: &Dataset, background: [f32; 3]) -> Place {
    let cameras: Vec<Camera> = dataset.views.iter().map(|view| view.camera).collect();
    let eyes = || cameras.iter().map(|camera| Vec3::from(camera.position()));
    let n = cameras.len() as f32;
    if dataset.forward_facing {
        let [near, far] = dataset.bounds.unwrap_or(FORWARD);
        let near = near.max(1e-3);
        let far = far.max(1.01 * near);
        let axis = cameras.iter().map(|camera| Vec3::from(camera.axis())).sum::<Vec3>();
        let middle = eyes().sum::<Vec3>() / n;
        let center = middle + axis.normalize_or(-Vec3::Z) * 0.5 * (near + far);
        let widest = cameras.iter().map(|camera| half_width(camera) * far);
        let half = widest.fold(0.5 * (far - near), f32::max);
        return Place { center: center.to_array(), half, depths: [near, far], background };
    }
    let known = dataset.aabb.or(dataset.reach.filter(|_| !dataset.has_alpha));
    let [low, high] = known.unwrap_or_else(|| {
        let hull = dataset.has_alpha.then(|| {
            let source = RaySource::new(dataset.views.clone(), Backdrop::Color(background));
            VisualHull::new(&source)
        });
        find_box(&cameras, hull.as_ref()).bounds()
    });
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    let center = 0.5 * (low + high);
    let half = (0.5 * (high - low)).max_element().max(1e-6);
    let radius = (0.5 * (high - low)).length();
    let distances = || eyes().map(|eye| eye.distance(center));
    let mean = distances().sum::<f32>() / n;
    let near = distances().fold(f32::INFINITY, f32::min) - radius;
    let far = distances().fold(0.0, f32::max) + radius;
    let depths = [near.max(NEAREST * mean.max(radius)), far];
    Place { center: center.to_array(), half, depths, background }
}

/// Half of what a camera sees at a distance of 1, along the longer side.
fn half_width(camera: &Camera) -> f32 {
    let side = |size: u32, focal: f32| 0.5 * size as f32 / focal;
    side(camera.width, camera.focal[0]).max(side(camera.height, camera.focal[1]))
}

impl Place {
    /// A point in coordinates in which the scene's cube is [−1, 1]³.
    pub(crate) fn to_unit(self, point: Vec3) -> Vec3 {
        (point - Vec3::from(self.center)) / self.half
    }

    /// A ray in these coordinates: its direction keeps its length, and distances along it are in
    /// half sides of the cube.
    pub(crate) fn ray(&self, ray: &Ray) -> [Vec3; 2] {
        [self.to_unit(Vec3::from(ray.origin)), Vec3::from(ray.direction)]
    }

    pub(crate) fn is_sound(&self) -> bool {
        let Self { center, half, depths: [near, far], background } = self;
        let finite = center.iter().chain(background).all(|v| v.is_finite());
        finite && *half > 0.0 && half.is_finite() && *near > 0.0 && far > near && far.is_finite()
    }
}
