//! Pictures: the nearest images, each rendered from the new camera, blended.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::Vec3;
use pocketnerf_core::{Camera, Error, Ray};
use pocketnerf_train::lens::Lens;
use rayon::prelude::*;

use super::image::{Image, Packed};

/// Images that are blended.
const NEAREST: usize = 5;
/// Images that are kept unpacked.
const KEPT: usize = 12;
/// Light below which planes behind are not seen.
const DARK: f32 = 1.0 / 512.0;

/// Images of which those that are needed are unpacked.
#[derive(Debug)]
pub(crate) struct Prepared<'b> {
    packed: &'b [Packed],
    /// Numbers and images, the last used ones first.
    images: VecDeque<(usize, Arc<Image>)>,
}

impl<'b> Prepared<'b> {
    /// Of these images.
    pub(super) fn new(packed: &'b [Packed]) -> Self {
        Self { packed, images: VecDeque::new() }
    }

    /// Premultiplied sRGB and opacity of the picture that a camera takes.
    pub(crate) fn paint(
        &mut self,
        camera: &Camera,
        lens: &Lens,
        rgba: &mut [f32],
    ) -> Result<(), Error> {
        let images = self.nearest(camera)?;
        let width = camera.width as usize;
        rgba.par_chunks_mut(4 * width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let ray = lens.ray(camera, x as f32 + 0.5, y as f32 + 0.5);
                *pixel = blended(&images, &ray);
            }
        });
        Ok(())
    }

    /// The images of the nearest cameras, with the weights that the paper gives them.
    fn nearest(&mut self, camera: &Camera) -> Result<Vec<(f32, Arc<Image>)>, Error> {
        let eye = Vec3::from(camera.position());
        let axis = Vec3::from(camera.axis());
        let mut order: Vec<(f32, usize)> = (0..self.packed.len())
            .map(|i| {
                let own = self.packed[i].camera();
                // Those that look the other way come last.
                let away = if axis.dot(Vec3::from(own.axis())) > 0.0 { 0.0 } else { 1e9 };
                (eye.distance(Vec3::from(own.position())) + away, i)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order.truncate(NEAREST);
        let least = order.first().map_or(0.0, |(distance, _)| *distance);
        let mut images = Vec::with_capacity(order.len());
        for (distance, i) in order {
            let image = self.image(i)?;
            // Relative to the nearest: all of them may be far away.
            let weight = (-image.falloff() * (distance - least)).exp();
            images.push((weight, image));
        }
        Ok(images)
    }

    fn image(&mut self, i: usize) -> Result<Arc<Image>, Error> {
        let kept = self.images.iter().position(|(number, _)| *number == i);
        let entry = match kept.and_then(|at| self.images.remove(at)) {
            Some(entry) => entry,
            None => {
                let image = self.packed[i].unpacked();
                (i, Arc::new(image.map_err(|_| Error::Range("planes of a multiplane image"))?))
            }
        };
        self.images.push_front(entry.clone());
        self.images.truncate(KEPT);
        Ok(entry.1)
    }
}

impl Image {
    /// How fast its weight falls with the distance of cameras: γ = f / (D z₀), the paper's.
    fn falloff(&self) -> f32 {
        let focal = self.planes.focal();
        focal / (self.planes.depths.len() as f32 * self.planes.depths[0])
    }

    /// Premultiplied sRGB and opacity of a ray.
    fn color(&self, ray: &Ray) -> [f32; 4] {
        let mut sum = [0.0; 4];
        let Some(local) = self.planes.local(ray) else { return sum };
        let width = self.planes.size()[0];
        let mut light = 1.0;
        for (k, values) in self.values.iter().enumerate() {
            let Some(spot) = self.planes.spot(&local, k) else { continue };
            let [mut r, mut g, mut b, mut opacity] = [0.0; 4];
            for (pixel, part) in spot.pixels(width) {
                let value = values[pixel].map(f32::from);
                let part = part / 255.0;
                r += part * value[0];
                g += part * value[1];
                b += part * value[2];
                opacity += part * value[3];
            }
            let share = light * opacity;
            sum.iter_mut().zip([r, g, b, 1.0]).for_each(|(sum, v)| *sum += share * v);
            light -= share;
            if light < DARK {
                break;
            }
        }
        sum
    }
}

/// Images weighted by their nearness and opacity. Where none shows anything, nothing is there.
fn blended(images: &[(f32, Arc<Image>)], ray: &Ray) -> [f32; 4] {
    let (mut sum, mut weights, mut most) = ([0.0; 3], 0.0, 0.0_f32);
    for (weight, image) in images {
        let [r, g, b, alpha] = image.color(ray);
        sum.iter_mut().zip([r, g, b]).for_each(|(sum, c)| *sum += weight * c);
        weights += weight * alpha;
        most = most.max(alpha);
    }
    if weights < 1e-6 {
        return [0.0; 4];
    }
    let [r, g, b] = sum.map(|c| c / weights * most);
    [r, g, b, most]
}
