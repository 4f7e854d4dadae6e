//! The cost of a picture, stage by stage.

mod frames;
mod watch;

use std::time::{Duration, Instant};

use pocketnerf_core::{Camera, Model, RenderOptions};
use pocketnerf_train::stopwatch;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

pub use frames::Variant;

use super::stage::{Crowd, Demand, Measured, StageCost, fraction_of_bounds, stages};
use super::{BenchError, work};
use crate::machine::{Machine, Probe};
use frames::{Job, Round, STAGES, all_empty, every_pixel, medians, variants};
use watch::Counts;

/// How long rounds are repeated, and the least number of rounds.
const TIME: Duration = Duration::from_secs(12);
const LEAST_ROUNDS: usize = 7;

/// The cost of a picture.
#[derive(Clone, Debug, Serialize)]
pub struct Rendering {
    /// Pictures of a round.
    pub views: usize,
    /// Width of a picture.
    pub width: u32,
    /// Height of a picture.
    pub height: u32,
    /// Rounds; times are medians over them.
    pub rounds: usize,
    /// All threads.
    pub frames_per_second: f64,
    /// All threads.
    pub seconds_per_frame: f64,
    /// One thread.
    pub seconds_per_frame_one_thread: f64,
    /// Samples that were evaluated, per pixel.
    pub samples_per_ray: f64,
    /// One thread, if no pixel is interpolated.
    pub seconds_per_frame_every_pixel: f64,
    /// Samples per pixel if none is interpolated.
    pub samples_per_ray_every_pixel: f64,
    /// Samples per ray that met an occupied cell.
    pub samples_per_hit_ray: f64,
    /// Samples per pixel including the padding of batches: what the kernels compute.
    pub rows_per_pixel: f64,
    /// Share of the pixels that are interpolated, or empty before a ray is cast.
    pub interpolated_share: f64,
    /// Rays that met an occupied cell, per pixel.
    pub hit_share: f64,
    /// A pixel whose ray misses the box, nanoseconds of one thread.
    pub ns_per_pixel_outside: f64,
    /// A ray that crosses only empty cells of the box, nanoseconds of one thread, without
    /// its camera; `null` if there is none.
    pub ns_per_pixel_empty: Option<f64>,
    /// A pixel whose ray meets nothing, on average: a ray through empty cells if one is cast,
    /// else as if it missed the box; `null` if there is none.
    pub ns_per_pixel_missed: Option<f64>,
    /// Speedup of all threads over one.
    pub scaling: Scaling,
    /// Other vector instructions, and smaller batches.
    pub variants: Vec<Variant>,
    /// Share of the time on one thread that the stages' bounds account for.
    pub fraction_of_bounds: f64,
    /// On one thread.
    pub stages: Vec<StageCost>,
}

/// Speedup of all threads over one, in the same rounds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Scaling {
    /// Threads.
    pub threads: usize,
    /// Of rendering.
    pub frame: f64,
    /// Of multiplications and additions in registers.
    pub fma: f64,
    /// Of reading memory beyond all caches.
    pub bandwidth: f64,
}

/// Measures pictures of `model` for 15 seconds, or in one round if
/// `quick`.
///
/// # Errors
/// Whatever rendering reports.
pub fn measure(
    model: &Model<'_>,
    cameras: &[Camera],
    options: &RenderOptions,
    machine: &Machine,
    quick: bool,
) -> Result<Rendering, BenchError> {
    let alone = ThreadPoolBuilder::new().num_threads(1).build()?;
    let probe = Probe::new(machine.simd, quick)?;
    let empty = all_empty(model, cameras, options)?;
    let job =
        Job { model, cameras, options: *options, alone: &alone, empty: &empty, probe: &probe };
    let begun = Instant::now();
    // Warms up the caches.
    let samples = [job.samples(options)?, job.samples(&every_pixel(options))?];
    let (mut rounds, mut counts) = (Vec::new(), Counts::default());
    while rounds.is_empty() || !quick && (rounds.len() < LEAST_ROUNDS || begun.elapsed() < TIME) {
        let (round, found) = job.round()?;
        rounds.push(round);
        counts = found;
    }
    Ok(summary(&job, machine, &medians(&rounds), rounds.len(), samples, &counts))
}

fn summary(
    job: &Job<'_>,
    machine: &Machine,
    median: &Round,
    rounds: usize,
    [samples, every]: [u64; 2],
    counts: &Counts,
) -> Rendering {
    let views = job.cameras.len() as f64;
    let pixels = counts.pixels as f64;
    let stages = stages(
        &measured(job.model, median, counts),
        median.one_thread,
        samples,
        machine,
        Crowd::OneThread,
    );
    let ways = variants(&job.options).into_iter().zip(&median.variants);
    let usual = ways.clone().find(|(options, _)| *options == job.options);
    let all_threads = *usual.expect("the level is available").1;
    let variant = |((options, seconds), relative): ((RenderOptions, &f64), &f64)| Variant {
        simd: options.simd.name(),
        tuning: if options.tuning == job.options.tuning { "fast" } else { "small" },
        frames_per_second: views / seconds,
        relative: *relative,
    };
    let n_empty = job.empty.rays.len();
    let ns_outside = median.outside * 1e9 / pixels;
    let ns_empty = (n_empty > 0).then(|| median.empty * 1e9 / n_empty as f64);
    let missed = job.empty.pixels as f64;
    let cast = (counts.rays - counts.hits) as f64 / missed;
    let ns_missed =
        cast.min(1.0) * ns_empty.unwrap_or(ns_outside) + (1.0 - cast).max(0.0) * ns_outside;
    Rendering {
        views: job.cameras.len(),
        width: job.cameras.first().map_or(0, |camera| camera.width),
        height: job.cameras.first().map_or(0, |camera| camera.height),
        rounds,
        frames_per_second: views / all_threads,
        seconds_per_frame: all_threads / views,
        seconds_per_frame_one_thread: median.one_thread / views,
        samples_per_ray: samples as f64 / pixels,
        seconds_per_frame_every_pixel: median.every_pixel / views,
        samples_per_ray_every_pixel: every as f64 / pixels,
        samples_per_hit_ray: samples as f64 / counts.hits.max(1) as f64,
        rows_per_pixel: counts.rows as f64 / pixels,
        interpolated_share: 1.0 - counts.rays as f64 / pixels,
        hit_share: counts.hits as f64 / pixels,
        ns_per_pixel_outside: ns_outside,
        ns_per_pixel_empty: ns_empty,
        ns_per_pixel_missed: (missed > 0.0).then_some(ns_missed),
        scaling: Scaling {
            threads: machine.threads,
            frame: median.scaling[0],
            fma: median.scaling[1],
            bandwidth: median.scaling[2],
        },
        variants: ways.zip(&median.relative).map(variant).collect(),
        fraction_of_bounds: fraction_of_bounds(&stages),
        stages,
    }
}

/// The stages with what bounds them.
fn measured(model: &Model<'_>, median: &Round, counts: &Counts) -> Vec<Measured> {
    let (field, samples) = (&model.field, counts.samples);
    let [density, color] = work::field_flops(field);
    let mut stages = STAGES.to_vec();
    if color == 0.0 {
        // Colours come with the densities.
        stages.pop();
    }
    // Opacity and channels of every sample, out of a batch of them.
    let composited = 4.0 * (1 + field.channels()) as f64;
    let stage = |(stage, seconds): (stopwatch::Stage, &f64)| {
        use stopwatch::Stage as S;
        let (name, unit, units, demand) = match stage {
            S::Interpolate => ("interpolate", "pixel", counts.pixels, Demand::default()),
            S::Camera => ("camera and way", "ray", counts.rays, Demand::default()),
            S::March => ("march", "sample", samples, Demand::default()),
            S::Encode => {
                let demand = Demand::gather(work::reads(field), work::encode_flops(field));
                ("encode", "sample", samples, demand)
            }
            S::Density => ("density network", "sample", samples, Demand::fma(density)),
            S::Composite => ("composite", "sample", samples, Demand::bandwidth(composited, 0.0)),
            _ => ("colour network", "hit ray", counts.hits, Demand::fma(color)),
        };
        Measured { name, unit, units, seconds: *seconds, demand }
    };
    stages.into_iter().zip(&median.stages).map(stage).collect()
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{SimdLevel, Tuning};

    use super::*;
    use pocketnerf_train::cameras::Circle;

    #[test]
    fn watched_pictures_are_the_renderers() {
        let bytes = include_bytes!("../../../../../embed-demo/still-life.pnerf");
        let file = pocketnerf_formats::open_verified(bytes).unwrap();
        let circle = Circle { size: [60, 50], ..Circle::around(&file.model.space, None, 2, 0.7) };
        let (model, cameras) = (&file.model, circle.cameras());
        let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
        let alone = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let probe = Probe::new(options.simd, true).unwrap();
        let empty = all_empty(model, &cameras, &options).unwrap();
        let cameras = &cameras;
        let job = Job { model, cameras, options, alone: &alone, empty: &empty, probe: &probe };
        let (_, counts) = job.round().unwrap();
        let samples = job.samples(&options).unwrap();
        assert!(job.samples(&every_pixel(&options)).unwrap() > samples);
        assert_eq!((counts.pixels, counts.samples), (2 * 60 * 50, samples));
        assert!(counts.rays < counts.pixels && counts.rows >= counts.samples);
        assert!(counts.hits > 100 && counts.hits < counts.rays && !empty.rays.is_empty());
        // Some rays that meet nothing are cast, others are known in advance.
        assert!(empty.pixels > empty.rays.len() as u64 && empty.pixels < counts.pixels);
    }
}
