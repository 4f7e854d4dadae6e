//! Rays through a model to pixels: the only loop over pixels.
//!
//! A tile's rays travel together. In every round each living ray adds its next
//! few occupied samples to a batch, the field answers for the whole batch, and
//! each ray composites its own part, so that a ray which has become opaque
//! asks for nothing more.

use fearless_simd::{Simd, dispatch};

use crate::composite::{self, Gathered};
use crate::field::{AnyField, Decoder, Field, Samples, Shading};
use crate::sampler::{Marcher, Path};
use crate::scratch::{Limits, RAY_FIELDS, Scratch, Tuning, scratch_len};
use crate::store::{F16, F32, Store};
use crate::tensor::DType;
use crate::{Camera, Error, Model, Ray, SimdLevel};

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Vector instructions.
    pub simd: SimdLevel,
    /// What the scratch was sized for.
    pub limits: Limits,
    /// How much is worked on at a time.
    pub tuning: Tuning,
    /// Cross empty space in strides. Without it every step is tested on its
    /// own: the same picture, slower.
    pub skip: bool,
}

impl RenderOptions {
    /// The usual way to render `model`: all it needs and no more.
    #[must_use]
    pub fn new(model: &Model<'_>, simd: SimdLevel, tuning: Tuning) -> Self {
        Self { simd, limits: model.field.limits(), tuning, skip: true }
    }

    fn check(&self, model: &Model<'_>) -> Result<(), Error> {
        // Cheap beside a tile's work, and kernels rely on it.
        model.validate()?;
        model.fits(&self.limits)?;
        let Tuning { samples, rays } = self.tuning;
        if samples == 0 || !samples.is_multiple_of(32) || rays == 0 || rays > samples {
            return Err(Error::Range("tuning: samples a multiple of 32, fewer rays than samples"));
        }
        Ok(())
    }

    /// `f32` values of scratch to hand to [`render_tile`].
    #[must_use]
    pub const fn scratch_len(&self) -> usize {
        scratch_len(self.limits, self.tuning)
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Tile {
    /// Pixels in the tile.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        (self.width as usize).saturating_mul(self.height as usize)
    }
}

/// What rendering a tile took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStats {
    /// Rays cast.
    pub rays: u64,
    /// Samples at which the field was asked.
    pub samples: u64,
}

/// Renders a tile of the picture that `camera` takes of `model`.
///
/// `rgba` receives four values a pixel, row after row of the tile: red, green
/// and blue premultiplied by alpha, without background, and alpha (opacity).
/// `depth`, where wanted, receives one value a pixel: the expected Euclidean
/// distance in scene units, infinite where the ray meets nothing.
/// `scratch` may hold anything; its length is [`RenderOptions::scratch_len`].
///
/// # Errors
/// When the parts of the model do not fit together, it exceeds
/// `options.limits`, a slice is too short, or the SIMD level is not there.
/// Nothing is written then.
pub fn render_tile(
    model: &Model<'_>,
    camera: &Camera,
    tile: Tile,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    let pixel = |i: usize| {
        let width = tile.width as usize;
        let (x, y) = ((i % width) as u32, (i / width) as u32);
        let (x, y) = (tile.x.saturating_add(x), tile.y.saturating_add(y));
        camera.ray(x as f32 + 0.5, y as f32 + 0.5)
    };
    render(model, tile.pixels(), pixel, options, scratch, rgba, depth)
}

/// Renders any rays: the same as [`render_tile`], one pixel a ray.
///
/// # Errors
/// As [`render_tile`].
pub fn render_rays(
    model: &Model<'_>,
    rays: &[Ray],
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    render(model, rays.len(), |i| rays[i], options, scratch, rgba, depth)
}

fn render(
    model: &Model<'_>,
    n: usize,
    ray: impl Fn(usize) -> Ray,
    options: &RenderOptions,
    scratch: &mut [f32],
    rgba: &mut [f32],
    mut depth: Option<&mut [f32]>,
) -> Result<RenderStats, Error> {
    options.check(model)?;
    if scratch.len() < options.scratch_len() {
        let (needed, given) = (options.scratch_len(), scratch.len());
        return Err(Error::ScratchTooSmall { needed, given });
    }
    let depth_len = depth.as_ref().map_or(usize::MAX, |d| d.len());
    for (needed, given) in [(n.saturating_mul(4), rgba.len()), (n, depth_len)] {
        if given < needed {
            return Err(Error::OutputLength { needed, given });
        }
    }
    let level = options.simd.token()?;
    let RenderOptions { limits, tuning, skip, .. } = *options;
    let mut scratch = Scratch::cut(scratch, limits, tuning);
    let marcher = Marcher::new(model, skip);
    let mut stats = RenderStats { rays: n as u64, samples: 0 };
    for first in (0..n).step_by(tuning.rays) {
        let count = tuning.rays.min(n - first);
        for (i, state) in scratch.rays[..count].iter_mut().enumerate() {
            *state = RayState::new(marcher.path(ray(first + i), 0.5)).pack();
        }
        let group = Group { model, marcher, most_samples: tuning.samples, count };
        let rgba = rgba[first * 4..].as_chunks_mut::<4>().0;
        let depth = depth.as_mut().map(|d| &mut d[first..]);
        stats.samples += dispatch!(level, simd => group.render(simd, &mut scratch, rgba, depth));
    }
    Ok(stats)
}

/// A ray in flight. Lies in the caller's scratch as [`RAY_FIELDS`] numbers.
struct RayState {
    path: Path,
    gathered: Gathered,
    /// Samples in the current batch.
    run: u32,
}

impl RayState {
    const fn new(path: Path) -> Self {
        Self { path, gathered: Gathered::NOTHING, run: 0 }
    }

    const fn pack(&self) -> [f32; RAY_FIELDS] {
        let Self { path: Path { ray, next, end, .. }, gathered, run } = self;
        let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
        let Gathered { transmittance, opacity, depth } = *gathered;
        let [next, end, run] = [f32::from_bits(*next), f32::from_bits(*end), f32::from_bits(*run)];
        [ox, oy, oz, dx, dy, dz, next, end, run, transmittance, opacity, depth]
    }

    const fn unpack(packed: &[f32; RAY_FIELDS]) -> Self {
        let [ox, oy, oz, dx, dy, dz, next, end, run, transmittance, opacity, depth] = *packed;
        let ray = Ray { origin: [ox, oy, oz], direction: [dx, dy, dz] };
        Self {
            path: Path { ray, next: next.to_bits(), end: end.to_bits(), phase: 0.5 },
            gathered: Gathered { transmittance, opacity, depth },
            run: run.to_bits(),
        }
    }

    const fn is_alive(&self) -> bool {
        self.path.next < self.path.end
    }
}

/// Rays that travel together.
struct Group<'m> {
    model: &'m Model<'m>,
    marcher: Marcher<'m>,
    most_samples: usize,
    count: usize,
}

/// Fewest and most samples that a ray adds to a batch. Few: nothing is asked
/// behind an opaque surface. Many: fewer rounds.
const RUN: core::ops::RangeInclusive<usize> = 4..=16;

impl Group<'_> {
    /// Opens the kind of field and the stored type: below here both are types.
    #[inline(always)]
    fn render<S: Simd>(
        &self,
        simd: S,
        scratch: &mut Scratch<'_>,
        rgba: &mut [[f32; 4]],
        depth: Option<&mut [f32]>,
    ) -> u64 {
        match &self.model.field {
            #[cfg(feature = "hash-grid")]
            AnyField::HashGrid(field) => self.render_field(simd, field, scratch, rgba, depth),
            #[cfg(feature = "frequency")]
            AnyField::Frequency(field) => self.render_field(simd, field, scratch, rgba, depth),
        }
    }

    #[inline(always)]
    fn render_field<S: Simd, F: Field>(
        &self,
        simd: S,
        field: &F,
        scratch: &mut Scratch<'_>,
        rgba: &mut [[f32; 4]],
        depth: Option<&mut [f32]>,
    ) -> u64 {
        match self.model.field.dtype() {
            DType::F32 => self.march::<S, F32, F>(simd, field, scratch, rgba, depth),
            DType::F16 => self.march::<S, F16, F>(simd, field, scratch, rgba, depth),
        }
    }

    #[inline(always)]
    fn march<S: Simd, T: Store, F: Field>(
        &self,
        simd: S,
        field: &F,
        scratch: &mut Scratch<'_>,
        rgba: &mut [[f32; 4]],
        depth: Option<&mut [f32]>,
    ) -> u64 {
        let channels = field.decoder().channels();
        scratch.channels[..self.count * channels].fill(0.0);
        let mut asked = 0;
        loop {
            let n = self.gather(field.decoder().shading, scratch);
            if n == 0 {
                break;
            }
            asked += n as u64;
            let padded = n.next_multiple_of(32);
            let Scratch { work, points, directions, .. } = scratch;
            for row in points.iter_mut().chain(directions.iter_mut()) {
                row[n..padded].fill(0.0);
            }
            let samples = Samples {
                points: [0, 1, 2].map(|axis| &points[axis][..padded]),
                directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
            };
            field.density_features::<S, T>(simd, samples, work);
            let step = self.model.sampling.step;
            composite::opacities(simd, &mut work.output[..padded], step);
            self.composite(channels, scratch);
        }
        if let Some(depth) = depth {
            for (depth, packed) in depth.iter_mut().zip(&scratch.rays[..self.count]) {
                *depth = RayState::unpack(packed).gathered.expected_depth();
            }
        }
        match field.decoder().shading {
            Shading::PerSample => self.write_sums(scratch, rgba),
            Shading::PerRay => self.shade::<S, T>(simd, field.decoder(), scratch, rgba),
        }
        asked
    }

    /// Fills a batch with the next samples of the living rays; gives their number.
    #[inline(always)]
    fn gather(&self, shading: Shading, scratch: &mut Scratch<'_>) -> usize {
        let Scratch { rays, points: [x, y, z], directions, t, .. } = scratch;
        let rays = &mut rays[..self.count];
        let alive = rays.iter().filter(|packed| RayState::unpack(packed).is_alive()).count();
        let most = (self.most_samples / alive.max(1)).clamp(*RUN.start(), *RUN.end());
        let mut n = 0;
        for packed in rays {
            let mut state = RayState::unpack(packed);
            let start = n;
            if state.is_alive() {
                let room = most.min(self.most_samples - n);
                self.marcher.advance(&mut state.path, room, |distance, u| {
                    [x[n], y[n], z[n]] = u;
                    t[n] = distance;
                    n += 1;
                });
                if shading == Shading::PerSample {
                    for (row, d) in directions.iter_mut().zip(state.path.ray.direction) {
                        row[start..n].fill(d);
                    }
                }
            }
            state.run = (n - start) as u32;
            *packed = state.pack();
        }
        n
    }

    /// Adds the batch to its rays; opaque rays end.
    #[inline(always)]
    fn composite(&self, channels: usize, scratch: &mut Scratch<'_>) {
        let Scratch { work, rays, channels: sums, t, .. } = scratch;
        let (alphas, features) = work.output.split_at(work.stride);
        let mut start = 0;
        for (packed, sums) in rays[..self.count].iter_mut().zip(sums.chunks_exact_mut(channels)) {
            let mut state = RayState::unpack(packed);
            let run = start..start + state.run as usize;
            start = run.end;
            if run.is_empty() {
                continue;
            }
            for s in run {
                let weight = state.gathered.add(alphas[s], t[s]);
                if weight > 0.0 {
                    for (sum, row) in sums.iter_mut().zip(features.chunks(work.stride)) {
                        *sum += weight * row[s];
                    }
                }
                if state.gathered.transmittance < self.model.sampling.min_transmittance {
                    state.path.next = state.path.end;
                    break;
                }
            }
            *packed = state.pack();
        }
    }

    /// Per-sample shading: the sums are the colour.
    #[inline(always)]
    fn write_sums(&self, scratch: &Scratch<'_>, rgba: &mut [[f32; 4]]) {
        let sums = scratch.channels.as_chunks::<3>().0;
        for ((pixel, packed), sum) in rgba.iter_mut().zip(&scratch.rays[..self.count]).zip(sums) {
            let alpha = RayState::unpack(packed).gathered.opacity;
            *pixel = [sum[0], sum[1], sum[2], alpha];
        }
    }

    /// Deferred shading: the colour network reads each hit ray's average
    /// features, `rgb = alpha * logistic(net(sum / alpha, direction))`.
    #[inline(always)]
    fn shade<S: Simd, T: Store>(
        &self,
        simd: S,
        decoder: &Decoder<'_>,
        scratch: &mut Scratch<'_>,
        rgba: &mut [[f32; 4]],
    ) {
        let Scratch { work, rays, channels: sums, directions, .. } = scratch;
        let channels = decoder.channels();
        let stride = work.stride;
        let states = rays[..self.count].iter().map(RayState::unpack);
        let hits = states.clone().zip(sums.chunks_exact(channels));
        let mut n = 0;
        for (state, sums) in hits.filter(|(state, _)| state.gathered.opacity > 0.0) {
            for (row, sum) in work.a.chunks_mut(stride).zip(sums) {
                row[n] = sum / state.gathered.opacity;
            }
            for (row, d) in directions.iter_mut().zip(state.path.ray.direction) {
                row[n] = d;
            }
            n += 1;
        }
        let padded = n.next_multiple_of(32);
        for row in work.a.chunks_mut(stride).take(channels) {
            row[n..padded].fill(0.0);
        }
        for row in directions.iter_mut() {
            row[n..padded].fill(0.0);
        }
        decoder.colors::<S, T>(simd, [0, 1, 2].map(|axis| &*directions[axis]), padded, work);
        let mut column = 0;
        for (state, pixel) in states.zip(rgba) {
            let alpha = state.gathered.opacity;
            *pixel = [0.0; 4];
            if alpha > 0.0 {
                let color = |row: usize| work.output[row * stride + column];
                *pixel = [alpha * color(1), alpha * color(2), alpha * color(3), alpha];
                column += 1;
            }
        }
    }
}
