//! What a step learns from: random pixels of all training views.

use pocketnerf_core::{Camera, Ray};

pub use super::backdrop::Backdrop;
use crate::dataset::{UNCLAIMED, View};
use crate::lens::Lens;
use crate::random::Random;
use crate::trainer::pixels::exposure::Exposure;

/// Which pixel of which view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pixel {
    /// Number of the view.
    pub(crate) view: u32,
    /// Column.
    pub(crate) x: u32,
    /// Row.
    pub(crate) y: u32,
}

/// A pixel to learn from.
#[derive(Clone, Copy, Debug)]
pub struct TrainingRay {
    /// Through the pixel's centre, or another point of it.
    pub ray: Ray,
    /// Where in its step each sample lies, 0 to 1.
    pub phase: f32,
    /// Colour behind the scene, or the mean of what may be behind it.
    pub background: [f32; 3],
    /// Variance of each channel of what may be behind it.
    pub background_variance: f32,
    /// The pixel's colour over that background.
    pub target: [f32; 3],
    /// The pixel's opacity.
    pub alpha: f32,
    /// Number of the tile that the pixel was drawn from.
    pub tile: u32,
    /// How much its error counts.
    pub weight: f32,
    /// By how much the scene is brighter in the photograph, where that is learnt.
    pub gains: Option<[f32; 3]>,
    /// Of which channels the target is the least value: the photograph was too bright there.
    pub at_least: [bool; 3],
}

/// How much what a plain background tells of opacity counts: more makes glass opaque, less loses
/// white parts on white.
const CLAIM: f32 = 3e-3;

/// Fewer views than this are few: there is more between them than they show.
const FEW: usize = 32;

/// Pixels drawn at most until one counts.
const DRAWS: u32 = 64;

/// A view that nobody took: what other fields show there.
pub(crate) struct Pseudo {
    pub(crate) camera: Camera,
    pub(crate) lens: Lens,
    /// Opaque RGBA.
    pub(crate) rgba: Vec<u8>,
}

/// The training views as a source of rays: photographs, then views that [teachers] show.
///
/// [teachers]: crate::trainer::prepass::Prepared::taught
#[derive(Debug)]
pub struct RaySource {
    /// How many of the views are photographs.
    n_photographs: usize,
    /// The model files whose mean the other views are.
    teachers: Vec<Vec<u8>>,
    cameras: Vec<Camera>,
    lenses: Vec<Lens>,
    images: Vec<Vec<u8>>,
    masks: Vec<Option<Vec<u8>>>,
    /// Where a view shows a plain background, its colour.
    behind: Vec<Option<[f32; 3]>>,
    backdrop: Backdrop,
    /// How photographs are evened out.
    exposure: Exposure,
    /// The nearest depth of the scene, scene units, where that is known or can be guessed.
    nearest: Option<f32>,
}

impl RaySource {
    /// Takes over the views' images.
    #[must_use]
    pub fn new(views: Vec<View>, backdrop: Backdrop) -> Self {
        let cameras: Vec<Camera> = views.iter().map(|view| view.camera).collect();
        let lenses = views.iter().map(|view| view.lens).collect();
        let behind = views.iter().map(|view| view.behind).collect();
        let (images, masks) = views.into_iter().map(|view| (view.rgba, view.mask)).unzip();
        let exposure = Exposure::default();
        Self {
            n_photographs: cameras.len(),
            teachers: Vec::new(),
            cameras,
            lenses,
            images,
            masks,
            behind,
            backdrop,
            exposure,
            nearest: None,
        }
    }

    /// Adds views that nobody took, the mean of these teachers.
    pub(crate) fn add_pseudo_views(
        &mut self,
        views: impl Iterator<Item = Pseudo>,
        teachers: Vec<Vec<u8>>,
    ) {
        for Pseudo { camera, lens, rgba } in views {
            self.cameras.push(camera);
            self.lenses.push(lens);
            self.images.push(rgba);
            self.masks.push(None);
            self.behind.push(None);
        }
        self.teachers = teachers;
    }

    /// The model files whose mean is learnt as well.
    pub(crate) fn teachers(&self) -> &[Vec<u8>] {
        &self.teachers
    }

    /// The cameras of the photographs.
    pub(crate) fn photographs(&self) -> &[Camera] {
        &self.cameras[..self.n_photographs]
    }

    /// Whether a view is a photograph.
    #[inline]
    pub(crate) const fn is_photograph(&self, view: u32) -> bool {
        (view as usize) < self.n_photographs
    }

    /// The share of all pixels that photographs have.
    pub(crate) fn photographed_share(&self) -> f64 {
        let pixels = |images: &[Vec<u8>]| images.iter().map(|rgba| rgba.len() as f64).sum::<f64>();
        pixels(&self.images[..self.n_photographs]) / pixels(&self.images).max(1.0)
    }

    /// The same with the nearest depth of the scene.
    #[must_use]
    pub(crate) fn with_nearest(self, nearest: Option<f32>) -> Self {
        Self { nearest, ..self }
    }

    /// The nearest depth of the scene, scene units, where that is known or can be guessed.
    pub(crate) const fn nearest(&self) -> Option<f32> {
        self.nearest
    }

    /// What pictures are to be seen on: what is behind the images, white where that may be
    /// any colour.
    #[must_use]
    pub fn display_background(&self) -> [f32; 3] {
        let plain: Vec<[f32; 3]> = self.behind.iter().flatten().copied().collect();
        match self.backdrop {
            Backdrop::Color(color) | Backdrop::Hidden(color) => color,
            Backdrop::Random if plain.is_empty() => [1.0; 3],
            Backdrop::Random => [0, 1, 2].map(|c| {
                let mut values: Vec<f32> = plain.iter().map(|color| color[c]).collect();
                values.sort_by(f32::total_cmp);
                values[values.len() / 2]
            }),
        }
    }

    /// Mean of each channel and variance of all of what may be behind a pixel with this
    /// `alpha`. Before a plain background all is compared as it looks there, and the variance
    /// is small: it settles what looks alike either way, such as a white part on white.
    pub(super) fn moments(&self, view: usize, alpha: u8) -> ([f32; 3], f32) {
        match (self.backdrop, self.behind[view]) {
            (Backdrop::Random, Some(color)) if alpha == UNCLAIMED => (color, 0.0),
            (Backdrop::Random, Some(color)) => (color, CLAIM),
            (backdrop, _) => backdrop.moments(),
        }
    }

    /// From now on photographs are multiplied by these gains, a view and channel; without any
    /// they are taken as they are.
    pub(crate) fn even_out(&mut self, gains: Vec<[f32; 3]>) {
        self.exposure = Exposure::new(gains);
    }

    /// From now on the scene is so many times brighter in each channel of each photograph than the
    /// gains say.
    pub(crate) fn brighten(&mut self, factors: Vec<[f32; 3]>) {
        self.exposure.set_factors(factors);
    }

    /// How photographs are evened out.
    pub(crate) fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// Whether the silhouettes are those of photographs before a plain background.
    pub(crate) fn is_cut_out(&self) -> bool {
        self.behind.iter().any(Option::is_some)
    }

    /// What is behind a view's photograph, where that is plain.
    pub(crate) fn behind(&self, view: usize) -> Option<[f32; 3]> {
        self.behind[view]
    }

    /// From now on the views' rays start from these cameras.
    pub(crate) fn move_cameras(&mut self, cameras: Vec<Camera>) {
        self.cameras = cameras;
    }

    /// The views' cameras.
    #[must_use]
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }

    /// Whether photographs are so few that they do not settle what lies between them.
    pub(crate) const fn has_few_views(&self) -> bool {
        self.n_photographs < FEW
    }

    /// Each camera's lens.
    #[must_use]
    pub fn lenses(&self) -> &[Lens] {
        &self.lenses
    }

    /// Which pixels of each image count, see [`View::mask`].
    #[must_use]
    pub fn masks(&self) -> &[Option<Vec<u8>>] {
        &self.masks
    }

    /// The ray through a pixel's centre.
    #[inline]
    pub(crate) fn through(&self, pixel: Pixel) -> Ray {
        let (x, y) = (pixel.x as f32 + 0.5, pixel.y as f32 + 0.5);
        self.lenses[pixel.view as usize].ray(&self.cameras[pixel.view as usize], x, y)
    }

    /// The ray through a point of a view, in pixels.
    pub(crate) fn through_point(&self, view: u32, [x, y]: [f32; 2]) -> Ray {
        self.lenses[view as usize].ray(&self.cameras[view as usize], x, y)
    }

    /// Whether all pixels of a view count.
    #[inline]
    pub(crate) fn all_count(&self, view: usize) -> bool {
        self.masks[view].is_none()
    }

    /// Whether the `i`-th pixel of a view counts.
    #[inline]
    pub(crate) fn counts(&self, view: usize, i: usize) -> bool {
        self.masks[view].as_ref().is_none_or(|mask| mask[i] != 0)
    }

    /// Whether it counts and tells how bright the scene is: it is not too bright for the photograph.
    pub(crate) fn is_exact(&self, view: usize, i: usize) -> bool {
        let rgba = self.images[view].as_chunks::<4>().0[i];
        self.counts(view, i) && self.exposure.at_least(view, rgba) == [false; 3]
    }

    /// The views' images, RGBA.
    #[must_use]
    pub fn images(&self) -> &[Vec<u8>] {
        &self.images
    }

    /// A pixel's straight RGBA, evened out.
    #[inline]
    pub(crate) fn rgba(&self, pixel: Pixel) -> [u8; 4] {
        self.exposure.even(pixel.view as usize, self.as_taken(pixel))
    }

    /// A pixel's straight RGBA, as the photograph has it.
    #[inline]
    pub(crate) fn as_taken(&self, pixel: Pixel) -> [u8; 4] {
        let width = self.cameras[pixel.view as usize].width as usize;
        let image = self.images[pixel.view as usize].as_chunks::<4>().0;
        image[pixel.y as usize * width + pixel.x as usize]
    }

    /// The ray through a pixel that shows `rgba`, drawn from a `tile` and weighing
    /// `weight`.
    #[inline]
    pub(crate) fn ray(
        &self,
        pixel: Pixel,
        rgba: [u8; 4],
        (tile, weight): (u32, f32),
        random: &mut Random,
    ) -> TrainingRay {
        let phase = random.next_f32();
        let (background, background_variance) = self.moments(pixel.view as usize, rgba[3]);
        let [r, g, b, alpha] = rgba.map(|value| f32::from(value) / 255.0);
        let [r0, g0, b0] = background.map(|value| (1.0 - alpha) * value);
        let target = [r * alpha + r0, g * alpha + g0, b * alpha + b0];
        let ray = self.through(pixel);
        let gains = self.exposure.factors(pixel.view as usize);
        let at_least = self.exposure.at_least(pixel.view as usize, self.as_taken(pixel));
        TrainingRay {
            ray,
            phase,
            background,
            background_variance,
            target,
            alpha,
            tile,
            weight,
            gains,
            at_least,
        }
    }

    /// A ray through any pixel of any view that counts, all alike; of the middle halves of
    /// the images where `cropped`.
    pub(crate) fn draw_anywhere(&self, cropped: bool, random: &mut Random) -> TrainingRay {
        let mut draw = || {
            let view = random.below(self.cameras.len());
            let camera = &self.cameras[view];
            let mut along = |pixels: u32| {
                let most = if cropped { (pixels / 2).max(1) } else { pixels };
                (pixels - most) / 2 + random.below(most as usize) as u32
            };
            Pixel { view: view as u32, x: along(camera.width), y: along(camera.height) }
        };
        let mut pixel = draw();
        for _ in 0..DRAWS {
            let width = self.cameras[pixel.view as usize].width;
            if self.counts(pixel.view as usize, (pixel.y * width + pixel.x) as usize) {
                break;
            }
            pixel = draw();
        }
        self.ray(pixel, self.rgba(pixel), (0, 1.0), random)
    }
}
