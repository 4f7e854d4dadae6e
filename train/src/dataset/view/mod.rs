//! One image and the camera that took it.

mod compression;
mod duplicates;
mod plain;
mod smaller;

use pocketnerf_core::{Camera, Ray};

use crate::lens::Lens;
pub(crate) use plain::UNCLAIMED;

/// One image and the camera that took it.
#[derive(Clone, Debug)]
pub struct View {
    /// What names the view in reports: the image's path relative to the dataset.
    pub name: String,
    /// The camera; its size is the image's.
    pub camera: Camera,
    /// What bends its rays.
    pub lens: Lens,
    /// `width * height` pixels, row after row from the top, straight (not
    /// premultiplied) RGBA; alpha 255 where the image has none.
    pub rgba: Vec<u8>,
    /// A byte a pixel: 0 where it is neither learnt from nor scored, as where the lens
    /// shows nothing. `None`: all count.
    pub mask: Option<Vec<u8>>,
    /// Euclidean distance along each pixel's ray to the first surface, scene
    /// units, where it is known exactly; infinite where the ray meets nothing.
    pub depth: Option<Vec<f32>>,
    /// The colour, sRGB, of the plain background that the photograph was taken before, where
    /// alpha was found from it: see [`Dataset::cut_out`](super::Dataset::cut_out).
    pub behind: Option<[f32; 3]>,
}

impl View {
    /// A pinhole camera's image, all of which counts.
    #[must_use]
    pub fn new(name: impl Into<String>, camera: Camera, rgba: Vec<u8>) -> Self {
        let (name, lens) = (name.into(), Lens::Pinhole);
        Self { name, camera, lens, rgba, mask: None, depth: None, behind: None }
    }

    /// How many of the pixels that count are transparent, and how many count.
    #[must_use]
    pub fn transparent(&self) -> [usize; 2] {
        let alpha = self.rgba.iter().skip(3).step_by(4);
        let add = |[n, all]: [usize; 2], &alpha: &u8| [n + usize::from(alpha < 255), all + 1];
        match &self.mask {
            None => alpha.fold([0; 2], add),
            Some(mask) => {
                let counted = alpha.zip(mask).filter(|(_, counts)| **counts != 0);
                counted.map(|(alpha, _)| alpha).fold([0; 2], add)
            }
        }
    }

    /// The ray through an image point, pixels from the top left corner: pixel (i, j)
    /// has its centre at (i + 0.5, j + 0.5). See [`Lens::ray`].
    #[must_use]
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        self.lens.ray(&self.camera, x, y)
    }

    /// The image point at which `p` (scene units) is seen, inside the picture or not;
    /// `None` where it is not. See [`Lens::project`].
    #[must_use]
    pub fn project(&self, p: [f32; 3]) -> Option<[f32; 2]> {
        self.lens.project(&self.camera, p)
    }
}
