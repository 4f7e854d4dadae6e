//! Whole pictures through the renderer, in interleaved rounds, so that disturbances affect
//! all ways of rendering.

use std::time::Instant;

use pocketnerf_core::render::{Detail, render_rays};
use pocketnerf_core::{Camera, Error, Model, RenderOptions, SimdLevel, Tuning};
use pocketnerf_train::picture::Renderer;
use pocketnerf_train::stopwatch::{Stage, Stopwatch};
use rayon::ThreadPool;
use serde::Serialize;

use super::watch::{Counts, Empty, empty, watch};
use crate::machine::Probe;

/// Stages of rendering, in their order.
pub(super) const STAGES: [Stage; 7] = [
    Stage::Interpolate,
    Stage::Camera,
    Stage::March,
    Stage::Encode,
    Stage::Density,
    Stage::Composite,
    Stage::Color,
];

/// Most rays through empty cells that are rendered per view.
const MOST_EMPTY: usize = 1 << 14;

/// The pictures, and how they are rendered.
pub(super) struct Job<'j> {
    pub(super) model: &'j Model<'j>,
    pub(super) cameras: &'j [Camera],
    pub(super) options: RenderOptions,
    /// A pool of one thread.
    pub(super) alone: &'j ThreadPool,
    /// The rays that meet nothing.
    pub(super) empty: &'j Empty,
    /// Measures the machine meanwhile.
    pub(super) probe: &'j Probe,
}

/// Seconds of the pictures of one round, or their medians over the rounds.
#[derive(Clone, Debug)]
pub(super) struct Round {
    /// Of each of [`STAGES`], on one thread.
    pub(super) stages: [f64; STAGES.len()],
    /// Every pixel rendered, on one thread.
    pub(super) every_pixel: f64,
    /// On one thread.
    pub(super) one_thread: f64,
    /// Of each of [`variants`], on all threads.
    pub(super) variants: Vec<f64>,
    /// Their speed, relative to the default.
    pub(super) relative: Vec<f64>,
    /// Of pictures in the opposite direction, on one thread.
    pub(super) outside: f64,
    /// Of the rays through empty cells alone, on one thread.
    pub(super) empty: f64,
    /// Speedup of all threads over one: for pictures, for multiplications and additions, and
    /// for reading memory.
    pub(super) scaling: [f64; 3],
}

/// A way to render: vector instructions, and memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Variant {
    /// Vector instructions.
    pub simd: &'static str,
    /// `fast` or `small`: the size of batches.
    pub tuning: &'static str,
    /// On all threads.
    pub frames_per_second: f64,
    /// Speed relative to the default, in the same rounds.
    pub relative: f64,
}

/// Every SIMD level that the machine has, best first, then little memory.
pub(super) fn variants(options: &RenderOptions) -> Vec<RenderOptions> {
    let levels = SimdLevel::ALL.into_iter().rev().filter(|level| level.is_available());
    let levels = levels.map(|simd| RenderOptions { simd, ..*options });
    levels.chain([RenderOptions { tuning: Tuning::SMALL, ..*options }]).collect()
}

impl Job<'_> {
    /// One round. The counts are the same in every round.
    pub(super) fn round(&self) -> Result<(Round, Counts), Error> {
        let stopwatch = Stopwatch::default();
        let mut counts = Counts::default();
        let every = every_pixel(&self.options);
        for camera in self.cameras {
            watch(self.model, camera, &self.options, &stopwatch, &mut counts)?;
        }
        let every_pixel = self.alone.install(|| self.pictures(&every, false))?;
        // Times that are compared are measured directly after each other.
        let one_thread = self.alone.install(|| self.pictures(&self.options, false))?;
        let usual = self.pictures(&self.options, false)?;
        let variants: Result<Vec<_>, Error> = variants(&self.options)
            .iter()
            .map(|options| match *options == self.options {
                true => Ok(usual),
                false => self.pictures(options, false),
            })
            .collect();
        let variants = variants?;
        let [fma, bandwidth] = self.probe.look().map(|rate| rate.all / rate.one_thread);
        let round = Round {
            stages: STAGES.map(|stage| stopwatch.seconds(stage)),
            every_pixel,
            one_thread,
            relative: variants.iter().map(|seconds| usual / seconds).collect(),
            variants,
            outside: self.alone.install(|| self.pictures(&self.options, true))?,
            empty: self.rays()?,
            scaling: [one_thread / usual, fma, bandwidth],
        };
        Ok((round, counts))
    }

    /// Seconds of all pictures, or of those in the opposite direction.
    fn pictures(&self, options: &RenderOptions, behind: bool) -> Result<f64, Error> {
        let mut renderer = Renderer::with_options(self.model, *options, false);
        let begun = Instant::now();
        for camera in self.cameras {
            let camera = if behind { turned(camera) } else { *camera };
            std::hint::black_box(renderer.render(&camera)?);
        }
        Ok(begun.elapsed().as_secs_f64())
    }

    /// Samples that the renderer evaluates.
    pub(super) fn samples(&self, options: &RenderOptions) -> Result<u64, Error> {
        let mut renderer = Renderer::with_options(self.model, *options, false);
        let samples =
            |camera: &Camera| renderer.render(camera).map(|picture| picture.stats.samples);
        self.cameras.iter().map(samples).sum()
    }

    /// Seconds of the rays through empty cells.
    fn rays(&self) -> Result<f64, Error> {
        let rays = &self.empty.rays[..];
        let mut scratch = vec![0.0; self.options.scratch_len()];
        let mut rgba = vec![0.0; 4 * rays.len()];
        let begun = Instant::now();
        render_rays(self.model, rays, &self.options, &mut scratch, &mut rgba, None)?;
        Ok(begun.elapsed().as_secs_f64())
    }
}

/// The same way to render, with every pixel.
pub(super) fn every_pixel(options: &RenderOptions) -> RenderOptions {
    RenderOptions { detail: Detail { tolerances: [0.0; 4], ..options.detail }, ..*options }
}

/// The rays of all views that meet nothing.
pub(super) fn all_empty(
    model: &Model<'_>,
    cameras: &[Camera],
    options: &RenderOptions,
) -> Result<Empty, Error> {
    let mut all = Empty::default();
    for camera in cameras {
        let Empty { rays, pixels } = empty(model, camera, options, MOST_EMPTY)?;
        all.rays.extend(rays);
        all.pixels += pixels;
    }
    Ok(all)
}

/// The camera, turned around.
pub(super) fn turned(camera: &Camera) -> Camera {
    let mut turned = *camera;
    for row in turned.camera_to_world.chunks_exact_mut(4).take(3) {
        // About the vertical axis of the picture.
        (row[0], row[2]) = (-row[0], -row[2]);
    }
    turned
}

/// The median of every number, of ratios too: disturbances of a round affect both sides of
/// its ratios.
pub(super) fn medians(rounds: &[Round]) -> Round {
    let of = |number: &dyn Fn(&Round) -> f64| median(rounds.iter().map(number).collect());
    let ways = 0..rounds[0].variants.len();
    Round {
        stages: std::array::from_fn(|stage| of(&|round| round.stages[stage])),
        every_pixel: of(&|round| round.every_pixel),
        one_thread: of(&|round| round.one_thread),
        variants: ways.clone().map(|i| of(&|round| round.variants[i])).collect(),
        relative: ways.map(|i| of(&|round| round.relative[i])).collect(),
        outside: of(&|round| round.outside),
        empty: of(&|round| round.empty),
        scaling: [0, 1, 2].map(|i| of(&|round| round.scaling[i])),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len().is_multiple_of(2) {
        0.5 * (values[middle - 1] + values[middle])
    } else {
        values[middle]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_numbers() {
        assert_eq!(median(vec![5.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 8.0]), 3.0);
    }

    #[test]
    fn a_turned_camera_looks_away() {
        let pose = Camera::look_at([3.0, 0.5, 1.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(8, 8, 0.7, pose);
        let [ray, away] = [camera, turned(&camera)].map(|c| c.ray(4.0, 4.0));
        assert_eq!(ray.origin, away.origin);
        assert!((0..3).all(|a| (ray.direction[a] + away.direction[a]).abs() < 1e-6));
    }
}
