//! Pictures of baselines.

use pocketnerf_core::{Camera, Error, Ray};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::{Painter, Picture};
use rayon::prelude::*;

use crate::photographs::Place;
use crate::scene::Scene;
use crate::{Baseline, llff, neural_volumes, srn};

/// Rays that a thread works on at a time.
const RAYS: usize = 512;

/// Renders pictures of a baseline, one after another.
#[derive(Debug)]
pub struct Renderer<'b> {
    place: &'b Place,
    scene: Prepared<'b>,
    picture: Picture,
}

/// What is made of a file before the first picture.
#[derive(Debug)]
enum Prepared<'b> {
    Llff(llff::Prepared<'b>),
    Srn(&'b srn::Srn, srn::Networks),
    NeuralVolumes(neural_volumes::Prepared),
}

impl<'b> Renderer<'b> {
    /// Of this baseline.
    #[must_use]
    pub fn new(baseline: &'b Baseline) -> Self {
        let scene = match &baseline.scene {
            Scene::Llff(llff) => Prepared::Llff(llff.prepare()),
            Scene::Srn(srn) => Prepared::Srn(srn, srn::Networks::new(srn.config)),
            Scene::NeuralVolumes(volume) => Prepared::NeuralVolumes(volume.prepare()),
        };
        Self { place: &baseline.record.place, scene, picture: Picture::default() }
    }
}

impl Painter for Renderer<'_> {
    /// Premultiplied sRGB and opacity on all threads of the current pool. Scene representation
    /// networks have the background among their colours: they are opaque.
    fn paint(&mut self, camera: &Camera, lens: &Lens) -> Result<&Picture, Error> {
        let Self { place, scene, picture } = self;
        let (width, height) = (camera.width, camera.height);
        let pixels = width as usize * height as usize;
        (picture.width, picture.height) = (width, height);
        picture.rgba.resize(4 * pixels, 0.0);
        if let Prepared::Llff(llff) = scene {
            llff.paint(camera, lens, &mut picture.rgba)?;
            return Ok(picture);
        }
        let scene = &*scene;
        let ray = |i: usize| {
            let (x, y) = (i % width as usize, i / width as usize);
            lens.ray(camera, x as f32 + 0.5, y as f32 + 0.5)
        };
        let parts = picture.rgba.par_chunks_mut(4 * RAYS).enumerate();
        parts.for_each(|(part, rgba)| {
            let first = part * RAYS;
            let rays: Vec<Ray> = (first..first + rgba.len() / 4).map(ray).collect();
            let pixels = rgba.as_chunks_mut::<4>().0;
            match scene {
                Prepared::Srn(srn, networks) => {
                    let colors = srn.colors(networks, place, &rays);
                    let colors = colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]);
                    pixels.iter_mut().zip(colors).for_each(|(pixel, color)| *pixel = color);
                }
                Prepared::NeuralVolumes(volume) => {
                    let colors = rays.iter().map(|ray| volume.color(place, ray));
                    pixels.iter_mut().zip(colors).for_each(|(pixel, color)| *pixel = color);
                }
                Prepared::Llff(_) => {}
            }
        });
        Ok(picture)
    }
}
