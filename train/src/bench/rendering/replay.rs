//! The renderer's loop once more, out of core's public parts, with a stopwatch
//! between its stages.
//!
//! Core reads no clock. What the loop itself costs and what its memory costs
//! differ a little from the renderer's: the whole frame is timed apart.

use fearless_simd::{Simd, dispatch};
use pocketnerf_core::composite;
use pocketnerf_core::field::{Decoder, Field, Samples, Shading};
use pocketnerf_core::sampler::Marcher;
use pocketnerf_core::store::{F16, F32, Store};
use pocketnerf_core::{AnyField, Camera, DType, Error, Model, Ray, RenderOptions, Tile};

use super::flight::{Batch, Flight};
use crate::picture;
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// What the rays of a picture have met.
#[derive(Clone, Debug, Default)]
pub(super) struct Counts {
    /// Rays cast.
    pub(super) rays: u64,
    /// Samples asked for.
    pub(super) samples: u64,
    /// The same with what fills up the batches.
    pub(super) rows: u64,
    /// Rays that met something.
    pub(super) hits: u64,
    /// Rays that crossed the box through empty cells alone.
    pub(super) empty: Vec<Ray>,
}

/// Renders a picture on this thread, and throws it away.
pub(super) fn replay(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    stopwatch: &Stopwatch,
) -> Result<Counts, Error> {
    let level = options.simd.token()?;
    let mut replay = Replay {
        model,
        marcher: Marcher::new(model, options.skip),
        most_samples: options.tuning.samples,
        batch: Batch::new(options.limits, options.tuning),
        flight: Flight::default(),
        stopwatch,
        counts: Counts::default(),
    };
    for tile in picture::tiles(camera.width, camera.height) {
        let pixels: Vec<usize> = (0..tile.pixels()).collect();
        for pixels in pixels.chunks(options.tuning.rays) {
            let rays = pixels.iter().map(|i| ray(camera, tile, *i));
            dispatch!(level, simd => replay.render(simd, rays));
        }
    }
    Ok(replay.counts)
}

#[inline(always)]
fn ray(camera: &Camera, tile: Tile, i: usize) -> Ray {
    let (x, y) = (i as u32 % tile.width, i as u32 / tile.width);
    camera.ray((tile.x + x) as f32 + 0.5, (tile.y + y) as f32 + 0.5)
}

struct Replay<'r, 'm> {
    model: &'r Model<'m>,
    marcher: Marcher<'m>,
    most_samples: usize,
    batch: Batch,
    flight: Flight,
    stopwatch: &'r Stopwatch,
    counts: Counts,
}

impl Replay<'_, '_> {
    #[inline(always)]
    fn render<S: Simd>(&mut self, simd: S, rays: impl ExactSizeIterator<Item = Ray>) {
        let model = self.model;
        match (&model.field, model.field.dtype()) {
            (AnyField::HashGrid(field), DType::F16) => self.march::<S, F16, _>(simd, field, rays),
            (AnyField::HashGrid(field), _) => self.march::<S, F32, _>(simd, field, rays),
            (AnyField::Frequency(field), DType::F16) => self.march::<S, F16, _>(simd, field, rays),
            (AnyField::Frequency(field), _) => self.march::<S, F32, _>(simd, field, rays),
            _ => unreachable!("kinds that this crate knows"),
        }
    }

    #[inline(always)]
    fn march<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        rays: impl ExactSizeIterator<Item = Ray>,
    ) {
        let Self { model, marcher, most_samples, batch, flight, stopwatch, counts } = self;
        let decoder = field.decoder();
        let (channels, shading) = (decoder.channels(), decoder.shading);
        let (n_rays, sampling) = (rays.len(), model.sampling);
        let mut laps = Laps::begin(Some(stopwatch));
        flight.start(simd, rays, channels, marcher);
        laps.end(Stage::Camera, n_rays);
        flight.remember();
        loop {
            let mut laps = Laps::begin(Some(stopwatch));
            let n = flight.gather(simd, marcher, shading, batch, *most_samples);
            let padded = n.next_multiple_of(32);
            for row in batch.points.iter_mut().chain(&mut batch.directions) {
                row[n..padded].fill(0.0);
            }
            laps.end(Stage::March, n);
            if n == 0 {
                break;
            }
            let (mut work, points, directions) = batch.parts(padded);
            field.encode::<S, T>(simd, points, work.a, work.stride);
            laps.end(Stage::Encode, n);
            decoder.density_features::<S, T>(simd, Samples { points, directions }, &mut work);
            laps.end(Stage::Density, n);
            composite::opacities(simd, &mut work.output[..padded], sampling.step);
            flight.composite(batch, n, channels, sampling.min_transmittance);
            laps.end(Stage::Composite, n);
            flight.count(batch, n);
            counts.rows += padded as u64;
            counts.samples += n as u64;
        }
        counts.rays += n_rays as u64;
        counts.hits += flight.gathered.iter().filter(|ray| ray.opacity > 0.0).count() as u64;
        let empty = flight.taken().filter(|(_, taken)| *taken == Some(0)).map(|(ray, _)| *ray);
        counts.empty.extend(empty);
        if shading == Shading::PerRay {
            self.shade::<S, T>(simd, decoder);
        }
    }

    /// The colour network of the rays that met something.
    #[inline(always)]
    fn shade<S: Simd, T: Store>(&mut self, simd: S, decoder: &Decoder<'_>) {
        let Self { batch, flight, stopwatch, model, .. } = self;
        let mut laps = Laps::begin(Some(stopwatch));
        let (channels, stride) = (decoder.channels(), batch.stride);
        let mut n = 0;
        for (i, (ray, _)) in flight.taken().enumerate() {
            let opacity = flight.gathered[i].opacity;
            if opacity > 0.0 {
                let sums = &flight.sums[i * channels..][..channels];
                for (row, sum) in batch.a.chunks_mut(stride).zip(sums) {
                    row[n] = sum / opacity;
                }
                for (row, d) in batch.directions.iter_mut().zip(ray.direction) {
                    row[n] = d;
                }
                n += 1;
            }
        }
        let padded = n.next_multiple_of(32);
        for row in batch.a.chunks_mut(stride).take(channels) {
            row[n..padded].fill(0.0);
        }
        for row in &mut batch.directions {
            row[n..padded].fill(0.0);
        }
        let (mut work, _, directions) = batch.parts(padded);
        decoder.colors::<S, T>(simd, directions, padded, &mut work);
        let (mut pixel, mut column) = ([0.0; 4], 0);
        for gathered in flight.gathered.iter().filter(|ray| ray.opacity > 0.0) {
            let alpha = gathered.alpha(model.sampling.min_transmittance);
            let color = |row: usize| alpha * batch.output[row * stride + column];
            pixel = std::hint::black_box([color(1), color(2), color(3), alpha]);
            column += 1;
        }
        std::hint::black_box(pixel);
        laps.end(Stage::Color, n);
    }
}
