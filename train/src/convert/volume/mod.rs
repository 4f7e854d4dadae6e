//! Volumes that no kind of field here holds: rendered as their programs render them, so that a
//! field can learn from the pictures.

mod factors;
mod shade;
mod svox2;
mod tensorf;
#[cfg(test)]
mod tests;

use pocketnerf_core::{Camera, ColorSpace, Display, Error, Ray, SimdLevel, Space};
use pocketnerf_formats::Scene;
use pocketnerf_formats::import::volume::{Svox2, TensoRf};
use rayon::prelude::*;

use crate::lens::Lens;
use crate::picture::{Painter, Picture};

use super::ConvertError;

/// Rays that a thread works on at a time.
const RAYS: usize = 256;
/// Rays end where less light than this is left.
const LEAST_LIGHT: f32 = 1e-6;

/// What svox2 multiplies the positions of Blender's datasets by.
const BLENDER_SCALE: f32 = 2.0 / 3.0;

/// A way to render rays.
trait Volume: core::fmt::Debug + Sync {
    /// Premultiplied colour and opacity of rays, and how many samples they took.
    fn trace(&self, rays: &[Ray], pixels: &mut [[f32; 4]]) -> u64;
}

/// Another program's volume, in that program's world.
#[derive(Debug)]
pub struct VolumeConversion {
    volume: Box<dyn Volume>,
    program: &'static str,
    space: Space,
    scene: Scene<'static>,
    background: [f32; 3],
}

impl VolumeConversion {
    /// A model of TensoRF, whose world is the dataset's. The colour behind it is not in the
    /// checkpoint; white as in its configs for objects unless given.
    ///
    /// # Errors
    /// What core refuses.
    pub fn tensorf(
        field: TensoRf,
        background: Option<[f32; 3]>,
        simd: SimdLevel,
    ) -> Result<Self, ConvertError> {
        let [min, max] = field.bounds;
        Self::new(
            Box::new(tensorf::Tensors::new(field, simd.token()?)?),
            "apchenstu/TensoRF",
            [min, max],
            Scene::default(),
            background,
        )
    }

    /// A grid of svox2. Its world is `scale` times as large as the dataset's: 2 / 3 as for
    /// Blender's datasets unless given. The colour behind it is white unless given.
    ///
    /// # Errors
    /// What core refuses.
    pub fn svox2(
        grid: Svox2,
        scale: Option<f32>,
        background: Option<[f32; 3]>,
    ) -> Result<Self, ConvertError> {
        let (center, radius) = (grid.center, grid.radius);
        let corner = |side: f32| [0, 1, 2].map(|a| center[a] + side * radius[a]);
        // Units of the dataset in one of that world.
        let scene = Scene { scale: 1.0 / scale.unwrap_or(BLENDER_SCALE), ..Scene::default() };
        let bounds = [corner(-1.0), corner(1.0)];
        Self::new(Box::new(svox2::Voxels::new(grid)), "sxyu/svox2", bounds, scene, background)
    }

    fn new(
        volume: Box<dyn Volume>,
        program: &'static str,
        [min, max]: [[f32; 3]; 2],
        scene: Scene<'static>,
        background: Option<[f32; 3]>,
    ) -> Result<Self, ConvertError> {
        let space = Space::Box { min, max };
        space.validate()?;
        let background = background.unwrap_or([1.0; 3]);
        Ok(Self { volume, program, space, scene, background })
    }

    /// The program that wrote the checkpoint.
    #[must_use]
    pub const fn program(&self) -> &'static str {
        self.program
    }

    /// The box that it fills, in its program's world.
    #[must_use]
    pub const fn space(&self) -> &Space {
        &self.space
    }

    /// From that world to the dataset's.
    #[must_use]
    pub const fn scene(&self) -> Scene<'static> {
        self.scene
    }

    /// What is behind it; its colours are sRGB.
    #[must_use]
    pub const fn display(&self) -> Display {
        Display {
            background: self.background,
            color_space: ColorSpace::Srgb,
            tolerance: Display::TOLERANCE,
        }
    }

    /// To take pictures of it.
    #[must_use]
    pub fn painter(&self) -> VolumePainter<'_> {
        VolumePainter { volume: &*self.volume, picture: Picture::default() }
    }
}

/// Renders pictures of a volume, one after another: a ray a pixel, as its program does.
#[derive(Debug)]
pub struct VolumePainter<'v> {
    volume: &'v dyn Volume,
    picture: Picture,
}

impl VolumePainter<'_> {
    /// Premultiplied colour and opacity along rays of the program's world.
    #[must_use]
    pub fn colors(&self, rays: &[Ray]) -> Vec<[f32; 4]> {
        let mut pixels = vec![[0.0; 4]; rays.len()];
        let parts = rays.par_chunks(RAYS).zip(pixels.par_chunks_mut(RAYS));
        parts.for_each(|(rays, pixels)| {
            self.volume.trace(rays, pixels);
        });
        pixels
    }
}

impl Painter for VolumePainter<'_> {
    fn paint(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error> {
        let Self { volume, picture } = self;
        let (width, height) = (camera.width as usize, camera.height as usize);
        (picture.width, picture.height) = (camera.width, camera.height);
        picture.rgba.resize(4 * width * height, 0.0);
        let ray = |i: usize| lens.ray(camera, (i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let parts = picture.rgba.par_chunks_mut(4 * RAYS).enumerate();
        picture.stats.samples = parts
            .map(|(part, rgba)| {
                let first = part * RAYS;
                let rays: Vec<Ray> = (first..first + rgba.len() / 4).map(ray).collect();
                volume.trace(&rays, rgba.as_chunks_mut::<4>().0)
            })
            .sum();
        Ok(picture)
    }
}
