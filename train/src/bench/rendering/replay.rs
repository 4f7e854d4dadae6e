//! The renderer's loop over every pixel once more, out of core's public parts,
//! with a stopwatch between its stages.
//!
//! Core reads no clock. What the loop itself costs and what its memory costs
//! differ a little from the renderer's: the whole frame is timed apart.

use fearless_simd::{Simd, dispatch};
use pocketnerf_core::composite;
use pocketnerf_core::field::{Decoder, Field, Samples, Shading};
use pocketnerf_core::sampler::{Bundle, LANES, Marcher};
use pocketnerf_core::store::{F16, F32, Store};
use pocketnerf_core::{AnyField, Camera, DType, Error, Model, Ray, RenderOptions, Tile};

use super::flight::{self, Batch, Flight};
use crate::picture;
use crate::stopwatch::{Laps, Stage, Stopwatch};

/// What the rays of a picture have met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Rays cast.
    pub(super) rays: u64,
    /// Samples asked for.
    pub(super) samples: u64,
    /// The same with what fills up the batches.
    pub(super) rows: u64,
    /// Rays that met something.
    pub(super) hits: u64,
}

/// Renders every pixel of a picture on this thread, throws it away, and adds to
/// `counts`.
pub(super) fn replay(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    stopwatch: &Stopwatch,
    counts: &mut Counts,
) -> Result<(), Error> {
    let level = options.simd.token()?;
    let mut replay = Replay {
        model,
        options,
        min_transmittance: options.detail.min_transmittance.max(model.sampling.min_transmittance),
        marcher: Marcher::new(model, options.skip),
        batch: Batch::new(options.limits, options.tuning),
        flight: Flight::default(),
        bundles: Vec::new(),
        stopwatch,
        counts,
    };
    for tile in picture::tiles(camera.width, camera.height) {
        dispatch!(level, simd => replay.render(simd, camera, tile));
    }
    Ok(())
}

/// The rays of a picture that cross the box through empty cells alone, at most
/// `most`.
pub(super) fn empty(
    model: &Model<'_>,
    camera: &Camera,
    options: &RenderOptions,
    most: usize,
) -> Result<Vec<Ray>, Error> {
    let level = options.simd.token()?;
    let marcher = Marcher::new(model, options.skip);
    let mut found = Vec::new();
    for i in 0..camera.width * camera.height {
        let ray = camera.ray((i % camera.width) as f32 + 0.5, (i / camera.width) as f32 + 0.5);
        let mut bundle = Bundle::EMPTY;
        bundle.set(0, &ray, 0.5);
        dispatch!(level, simd => marcher.enter(simd, &mut bundle));
        (1..LANES).for_each(|lane| bundle.stop(lane));
        let entered = bundle.alive() > 0;
        dispatch!(level, simd => marcher.seek(simd, &mut bundle));
        if entered && bundle.alive() == 0 && found.len() < most {
            found.push(ray);
        }
    }
    Ok(found)
}

struct Replay<'r, 'm> {
    model: &'r Model<'m>,
    options: &'r RenderOptions,
    min_transmittance: f32,
    marcher: Marcher<'m>,
    batch: Batch,
    flight: Flight,
    bundles: Vec<Bundle>,
    stopwatch: &'r Stopwatch,
    counts: &'r mut Counts,
}

impl Replay<'_, '_> {
    #[inline(always)]
    fn render<S: Simd>(&mut self, simd: S, camera: &Camera, tile: Tile) {
        let model = self.model;
        match (&model.field, model.field.dtype()) {
            (AnyField::HashGrid(field), DType::F16) => {
                self.tile::<S, F16, _>(simd, field, camera, tile);
            }
            (AnyField::HashGrid(field), _) => self.tile::<S, F32, _>(simd, field, camera, tile),
            (AnyField::Frequency(field), DType::F16) => {
                self.tile::<S, F16, _>(simd, field, camera, tile);
            }
            (AnyField::Frequency(field), _) => self.tile::<S, F32, _>(simd, field, camera, tile),
            _ => unreachable!("kinds that this crate knows"),
        }
    }

    /// Rays are aimed a few hundred at a time, not sixteen: or the clock would be
    /// what is timed.
    #[inline(always)]
    fn tile<S: Simd, T: Store, F: Field>(
        &mut self,
        simd: S,
        field: &F,
        camera: &Camera,
        tile: Tile,
    ) {
        let (pixels, most) = (tile.pixels(), self.options.tuning.rays);
        self.counts.rays += pixels as u64;
        for first in (0..pixels).step_by(most.max(256)) {
            let end = pixels.min(first + most.max(256));
            let mut laps = Laps::begin(Some(self.stopwatch));
            self.bundles.clear();
            for first in (first..end).step_by(LANES) {
                let mut bundle = flight::rays(simd, camera, tile, first);
                self.marcher.enter(simd, &mut bundle);
                (end - first..LANES).for_each(|lane| bundle.stop(lane));
                self.bundles.push(bundle);
            }
            laps.end(Stage::Camera, end - first);
            for i in 0..self.bundles.len() {
                self.flight.add(simd, &self.marcher, &self.bundles[i]);
                if self.flight.count + LANES > most {
                    laps.end(Stage::March, 0);
                    self.march::<S, T, F>(simd, field);
                    laps = Laps::begin(Some(self.stopwatch));
                }
            }
            laps.end(Stage::March, 0);
        }
        self.march::<S, T, F>(simd, field);
    }

    /// Takes all rays to their ends.
    #[inline(always)]
    fn march<S: Simd, T: Store, F: Field>(&mut self, simd: S, field: &F) {
        let Self { model, options, min_transmittance, marcher, batch, flight, .. } = self;
        let decoder = field.decoder();
        let (channels, shading) = (decoder.channels(), decoder.shading);
        let mut laps = Laps::begin(Some(self.stopwatch));
        flight.sums.clear();
        flight.sums.resize(flight.count * channels, 0.0);
        loop {
            let most = options.tuning.samples;
            let n = flight.gather(simd, marcher, shading, batch, most, *min_transmittance);
            let padded = n.next_multiple_of(32);
            for row in batch.points.iter_mut().chain(&mut batch.directions) {
                row[n..padded].fill(0.0);
            }
            laps.end(Stage::March, n);
            if n == 0 {
                break;
            }
            let (mut work, points, directions) = batch.parts(padded);
            field.encode(simd, points, work.a, work.stride);
            laps.end(Stage::Encode, n);
            decoder.density_features::<S, T>(simd, Samples { points, directions }, &mut work);
            laps.end(Stage::Density, n);
            composite::opacities(simd, &mut work.output[..padded], model.sampling.step);
            flight.composite(batch, n, channels, *min_transmittance);
            laps.end(Stage::Composite, n);
            self.counts.rows += padded as u64;
            self.counts.samples += n as u64;
        }
        if shading == Shading::PerRay {
            self.shade::<S, T>(simd, decoder);
        }
        let met = self.flight.gathered().filter(|(gathered, _)| gathered.opacity > 0.0);
        self.counts.hits += met.count() as u64;
        self.flight.clear();
    }

    /// The colour network of the rays that met something.
    #[inline(always)]
    fn shade<S: Simd, T: Store>(&mut self, simd: S, decoder: &Decoder<'_>) {
        let Self { batch, flight, stopwatch, min_transmittance, .. } = self;
        let mut laps = Laps::begin(Some(stopwatch));
        let (channels, stride) = (decoder.channels(), batch.stride);
        let mut n = 0;
        let all = flight.gathered().zip(flight.sums.chunks_exact(channels));
        for ((gathered, direction), sums) in all.filter(|((ray, _), _)| ray.opacity > 0.0) {
            for (row, sum) in batch.a.chunks_mut(stride).zip(sums) {
                row[n] = sum / gathered.opacity;
            }
            for (row, d) in batch.directions.iter_mut().zip(direction) {
                row[n] = d;
            }
            n += 1;
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
        let met = flight.gathered().filter(|(gathered, _)| gathered.opacity > 0.0);
        for (column, (gathered, _)) in met.enumerate() {
            let alpha = gathered.alpha(*min_transmittance);
            let color = |row: usize| alpha * batch.output[row * stride + column];
            std::hint::black_box([color(1), color(2), color(3), alpha]);
        }
        laps.end(Stage::Color, n);
    }
}
