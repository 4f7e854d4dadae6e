//! Local light field fusion (Mildenhall et al. 2019): a multiplane image for each photograph;
//! a new view blends those of the nearest. The paper's network, which makes such images of any
//! scene, was trained on many scenes; here each image is learnt from the photographs around it.

mod blend;
mod image;
mod learn;
mod planes;
mod sweep;
#[cfg(test)]
pub(crate) mod tests;

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::photographs::{Photograph, Photographs};
use crate::run::At;
pub(crate) use blend::Prepared;
use image::{Packed, Shape};
use learn::{Seen, Target};
use sweep::{blurred, sweep};

/// Planes of an image.
const PLANES: usize = 32;
/// Photographs around one that its image is learnt from.
const AROUND: usize = 4;
/// Learning rate at first and in the end.
const RATES: [f32; 2] = [0.02, 0.005];
/// Decay of the mean gradient, and of the mean squared one.
const BETAS: [f32; 2] = [0.8, 0.95];
/// Keeps the division finite.
const EPSILON: f32 = 1e-3;

/// What was learnt: images.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Llff {
    images: Vec<Packed>,
}

impl Llff {
    pub(crate) fn is_sound(&self) -> bool {
        !self.images.is_empty() && self.images.iter().all(Packed::is_sound)
    }

    /// Numbers that were learnt.
    pub(crate) fn values(&self) -> usize {
        self.images.iter().map(Packed::values).sum()
    }

    /// Photographs that have an image.
    pub(crate) fn len(&self) -> usize {
        self.images.len()
    }

    /// To render.
    pub(crate) fn prepare(&self) -> Prepared<'_> {
        Prepared::new(&self.images)
    }
}

/// Training in progress: one image after the other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Training {
    done: Vec<Packed>,
    current: Option<Work>,
}

/// The image that is being learnt.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Work {
    shape: Shape,
    step: u32,
    planes: Vec<Plane>,
}

/// A plane's values, sRGB and opacity, and their moments.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Plane {
    values: Vec<[f32; 4]>,
    mean: Vec<[f32; 4]>,
    square: Vec<[f32; 4]>,
}

impl Plane {
    fn new(values: Vec<[f32; 4]>) -> Self {
        let zero = vec![[0.0; 4]; values.len()];
        Self { values, mean: zero.clone(), square: zero }
    }

    /// Adam, and then everything is between 0 and 1 again.
    fn step(&mut self, gradient: &[[f32; 4]], rate: f32) {
        let [values, mean, square] = [&mut self.values, &mut self.mean, &mut self.square]
            .map(|values| values.as_flattened_mut());
        let moments = mean.iter_mut().zip(square);
        for ((own, g), (m, v)) in values.iter_mut().zip(gradient.as_flattened()).zip(moments) {
            *m += (g - *m) * (1.0 - BETAS[0]);
            *v += (g * g - *v) * (1.0 - BETAS[1]);
            *own = (*own - rate * *m / (v.sqrt() + EPSILON)).clamp(0.0, 1.0);
        }
    }
}

impl Work {
    fn packed(&self) -> Packed {
        Packed::new(self.shape, self.planes.par_iter().map(|plane| &plane.values[..]))
    }

    fn is_sound(&self) -> bool {
        let pixels = self.shape.planes().pixels();
        let sound = |plane: &Plane| {
            let Plane { values, mean, square } = plane;
            [values, mean, square].iter().all(|values| values.len() == pixels)
        };
        let planes = [self.planes.len(), self.shape.planes().depths.len()];
        planes == [PLANES; 2] && self.planes.iter().all(sound)
    }
}

impl Training {
    pub(crate) fn new() -> Self {
        Self { done: Vec::new(), current: None }
    }

    /// The result so far.
    pub(crate) fn scene(&self) -> Llff {
        let mut images = self.done.clone();
        images.extend(self.current.as_ref().map(Work::packed));
        Llff { images }
    }

    /// Bytes of the images that are done.
    pub(crate) fn bytes(&self) -> usize {
        self.done.iter().map(Packed::bytes).sum()
    }

    pub(crate) fn is_sound(&self) -> bool {
        let current = self.current.as_ref();
        self.done.iter().all(Packed::is_sound)
            && current.is_none_or(|work| work.shape.is_sound() && work.is_sound())
    }

    /// One step; gives the mean squared error of its pixels.
    pub(crate) fn step(&mut self, photographs: &Photographs, at: At) -> f64 {
        let n = photographs.all.len();
        // The images that should be done by now; shares are rounded.
        let due = ((at.share * n as f32 + 1e-3) as usize).min(n - 1);
        if self.done.len() < due
            && let Some(work) = self.current.take()
        {
            self.done.push(work.packed());
        }
        let number = order(n)[self.done.len().min(n - 1)];
        let own = &photographs.all[number];
        let around = around(photographs, number);
        let place = &photographs.place;
        let share = (at.share * n as f32 - self.done.len() as f32).clamp(0.0, 1.0);
        let work = self.current.get_or_insert_with(|| {
            let shape = Shape::new(&own.camera, place.depths, PLANES);
            let values = sweep(&shape.planes(), own, &around);
            Work { shape, step: 0, planes: values.into_iter().map(Plane::new).collect() }
        });
        // Its own photograph and those around it, by turns.
        let turn = work.step as usize % (around.len() + 1);
        let target = if turn == 0 { own } else { around[turn - 1] };
        work.step += 1;
        let correct = |beta: f32| 1.0 - beta.powi(work.step.min(1 << 16) as i32);
        let rate = At { share, ..at }.between(RATES) * correct(BETAS[1]).sqrt() / correct(BETAS[0]);
        let planes = work.shape.planes();
        let width = planes.size()[0];
        let values: Vec<&[[f32; 4]]> = work.planes.iter().map(|plane| &plane.values[..]).collect();
        let seen = Seen::of(&planes, &values, &targets(target), place.background);
        work.planes.par_iter_mut().enumerate().for_each(|(k, plane)| {
            let mut gradient = seen.gradient(k);
            // Neighbouring pixels mostly lie on one surface. Left alone, each explains its few
            // photographs in a way of its own, and views between them get worse from step to step.
            let opacities: Vec<f32> = gradient.iter().map(|value| value[3]).collect();
            let smooth = blurred(&opacities, width);
            gradient.iter_mut().zip(smooth).for_each(|(value, opacity)| value[3] = opacity);
            plane.step(&gradient, rate);
        });
        seen.error()
    }
}

/// All pixels of a photograph.
fn targets(photograph: &Photograph) -> Vec<Target> {
    let width = photograph.camera.width as usize;
    let pixels = 0..width * photograph.camera.height as usize;
    let target = |pixel: usize| {
        let (x, y) = ((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        let ray = photograph.lens.ray(&photograph.camera, x, y);
        Target { ray, color: photograph.color(pixel), counts: photograph.counts(pixel) }
    };
    pixels.into_par_iter().map(target).collect()
}

/// The photographs nearest to one that look the same way.
fn around(photographs: &Photographs, number: usize) -> Vec<&Photograph> {
    let own = &photographs.all[number].camera;
    let mut order: Vec<(f32, &Photograph)> = photographs
        .all
        .iter()
        .enumerate()
        .filter(|(i, other)| {
            *i != number && Vec3::from(own.axis()).dot(Vec3::from(other.camera.axis())) > 0.5
        })
        .map(|(_, other)| {
            let between = Vec3::from(own.position()).distance(Vec3::from(other.camera.position()));
            (between, other)
        })
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    order.into_iter().take(AROUND).map(|(_, photograph)| photograph).collect()
}

/// All numbers below `n`, so that those that follow each other are far apart.
fn order(n: usize) -> Vec<usize> {
    let key = |i: &usize| (*i as f64 * 0.618_033_988_749_895).fract();
    let mut order: Vec<usize> = (0..n).collect();
    // Places of the sequence i φ mod 1, sorted: each next number is far from the last ones.
    order.sort_by(|a, b| key(a).total_cmp(&key(b)));
    let mut numbers = vec![0; n];
    for (rank, i) in order.into_iter().enumerate() {
        numbers[i] = rank;
    }
    numbers
}
