//! How strongly photographs were compressed by JPEG, whatever kind of file they are in now.
//!
//! JPEG rounds the cosine transform of each block of 8x8 pixels to multiples of a step (ITU-T T.81).
//! Where the values of a frequency lie at multiples of one number only, that number is the step,
//! and from the steps of the standard's tables follows the quality.

use std::f32::consts::PI;

use rayon::prelude::*;

use crate::dataset::{Dataset, View};
use crate::metrics::quantile;

/// Pixels along a side of a block.
const SIDE: usize = 8;
/// Frequencies that are looked at, `[across, down]`, with their steps at quality 50 (T.81, table
/// K.1).
const FREQUENCIES: [([usize; 2], f32); 5] =
    [([1, 0], 11.0), ([0, 1], 12.0), ([1, 1], 12.0), ([2, 0], 10.0), ([0, 2], 14.0)];
/// Steps that are told apart from the rounding of pixels.
const STEPS: core::ops::RangeInclusive<u32> = 5..=120;
/// Values must lie at multiples this well: 1 exactly, 0 anywhere.
const SHARP: f32 = 0.75;
/// Fewer values than this that are not near 0 say nothing.
const FEWEST: usize = 40;
/// Blocks that are looked at, of all photographs together, about.
const BLOCKS: usize = 8192;

impl Dataset {
    /// The quality, 1 to 100, at which the photographs were compressed by JPEG, where it is low
    /// enough to be seen in their pixels, and these were not resized since.
    #[must_use]
    pub fn jpeg_quality(&self) -> Option<f32> {
        let pixels: usize = self.views.iter().map(|view| view.rgba.len() / 4).sum();
        let apart = (pixels / (SIDE * SIDE * BLOCKS)).max(1);
        let blocks: Vec<_> =
            self.views.par_iter().flat_map_iter(|view| blocks(view, apart)).collect();
        let of = |(frequency, usual): &([usize; 2], f32)| {
            let wave = wave(*frequency);
            let value =
                |block: &[f32; SIDE * SIDE]| block.iter().zip(&wave).map(|(a, b)| a * b).sum();
            let values: Vec<f32> = blocks.iter().map(value).collect();
            step(&values).map(|step| f64::from(step / usual))
        };
        let mut scales: Vec<f64> = FREQUENCIES.iter().filter_map(of).collect();
        scales.sort_by(f64::total_cmp);
        let is_known = 2 * scales.len() > FREQUENCIES.len();
        let scale = quantile(&scales, 0.5).filter(|_| is_known)? as f32;
        // How the quality scales the tables (Independent JPEG Group).
        Some(if scale > 1.0 { 50.0 / scale } else { 100.0 - 50.0 * scale })
    }
}

/// The cosine of a frequency over a block, normalised.
fn wave([u, v]: [usize; 2]) -> [f32; SIDE * SIDE] {
    let along = |k: usize, i: usize| {
        let norm = if k == 0 { (1.0 / SIDE as f32).sqrt() } else { (2.0 / SIDE as f32).sqrt() };
        norm * (PI * (2 * i + 1) as f32 * k as f32 / (2 * SIDE) as f32).cos()
    };
    core::array::from_fn(|i| along(u, i % SIDE) * along(v, i / SIDE))
}

/// The luma of every few blocks, where they are opaque.
fn blocks(view: &View, apart: usize) -> Vec<[f32; SIDE * SIDE]> {
    let width = view.camera.width as usize;
    let [across, down] = [width / SIDE, view.camera.height as usize / SIDE];
    let pixels = view.rgba.as_chunks::<4>().0;
    let block = |number: usize| {
        let first = number / across * SIDE * width + number % across * SIDE;
        let at = |i: usize| pixels[first + i / SIDE * width + i % SIDE];
        let is_opaque = (0..SIDE * SIDE).all(|i| at(i)[3] == u8::MAX);
        is_opaque.then(|| {
            core::array::from_fn(|i| {
                let [r, g, b, _] = at(i).map(f32::from);
                0.299 * r + 0.587 * g + 0.114 * b
            })
        })
    };
    (0..across * down).step_by(apart).filter_map(block).collect()
}

/// The largest number of which all values are multiples, but for the rounding of pixels.
fn step(values: &[f32]) -> Option<f32> {
    let sharpness = |step: f32| {
        let far = values.iter().filter(|value| value.abs() > 0.5 * step);
        let (n, sum) =
            far.fold((0, 0.0), |(n, sum), value| (n + 1, sum + (2.0 * PI * value / step).cos()));
        (n >= FEWEST).then(|| sum / n as f32)
    };
    let steps = STEPS.rev().map(|step| step as f32);
    steps.into_iter().find(|step| sharpness(*step).is_some_and(|sharp| sharp > SHARP))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::Split;

    fn compressed(quality: u8) -> Dataset {
        let mut dataset = builtin::Scene::Room.dataset(Split::Train, 4);
        for view in &mut dataset.views {
            let (width, height) = (view.camera.width, view.camera.height);
            let pixels = view.rgba.as_chunks_mut::<4>().0;
            let rgb: Vec<u8> =
                pixels.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
            let mut bytes = Vec::new();
            image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality)
                .encode(&rgb, width, height, image::ExtendedColorType::Rgb8)
                .unwrap();
            let decoded = image::load_from_memory(&bytes).unwrap().into_rgb8();
            for (pixel, new) in pixels.iter_mut().zip(decoded.pixels()) {
                pixel[..3].copy_from_slice(&new.0);
            }
        }
        dataset
    }

    #[test]
    fn the_quality_of_photographs_that_were_compressed() {
        for quality in [10, 30, 50, 70] {
            let found = compressed(quality).jpeg_quality().unwrap();
            println!("{quality}: {found}");
            assert!((found / f32::from(quality) - 1.0).abs() < 0.1, "{quality}: {found}");
        }
        for scene in [builtin::Scene::Room, builtin::Scene::StillLife] {
            assert_eq!(scene.dataset(Split::Train, 4).jpeg_quality(), None);
        }
    }
}
