//! Rays that travel together, from start to pixel.

use fearless_simd::Simd;

use crate::composite::{self, Gathered};
use crate::field::{AnyField, Decoder, Field, Samples, Shading};
use crate::sampler::{Bundle, LANES, Marcher};
use crate::scratch::{RAY_ROWS, Scratch};
use crate::store::{F16, F32, Store};
use crate::tensor::DType;
use crate::{Model, Ray};

/// Rays that travel together.
pub(super) struct Group<'m> {
    pub(super) model: &'m Model<'m>,
    pub(super) marcher: Marcher<'m>,
    pub(super) most_samples: usize,
    pub(super) count: usize,
}

/// Fewest and most samples that a ray adds to a batch. Few: nothing is asked
/// behind an opaque surface. Many: fewer rounds.
const RUN: core::ops::RangeInclusive<usize> = 4..=16;

/// Sixteen rays in flight, as they lie in the caller's scratch.
type Rows = [[f32; LANES]; RAY_ROWS];
/// Rows of what a ray has gathered; a [`Bundle`] takes those before.
const TRANSMITTANCE: usize = 9;
const OPACITY: usize = 10;
const DEPTH: usize = 11;

fn bundle(rows: &Rows) -> Bundle {
    let [ox, oy, oz, dx, dy, dz, phase, next, end, ..] = *rows;
    Bundle { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end }
}

fn start(bundle: &Bundle) -> Rows {
    let Bundle { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end } = *bundle;
    let [none, all] = [[0.0; LANES], [1.0; LANES]];
    [ox, oy, oz, dx, dy, dz, phase, next, end, all, none, none]
}

/// Where [`start`] puts the direction, the next step and the end.
const DIRECTION: core::ops::Range<usize> = 3..6;
const NEXT: usize = 7;
const END: usize = 8;

fn gathered(rows: &Rows, lane: usize) -> Gathered {
    Gathered {
        transmittance: rows[TRANSMITTANCE][lane],
        opacity: rows[OPACITY][lane],
        depth: rows[DEPTH][lane],
    }
}

impl Group<'_> {
    /// Opens the kind of field and the stored type: below here both are types.
    #[inline(always)]
    pub(super) fn render<S: Simd>(
        &self,
        simd: S,
        ray: impl Fn(usize) -> Ray,
        scratch: &mut Scratch<'_>,
        rgba: &mut [[f32; 4]],
        depth: Option<&mut [f32]>,
    ) -> u64 {
        for (first, rows) in (0..self.count).step_by(LANES).zip(&mut *scratch.rays) {
            let mut bundle = Bundle::EMPTY;
            let count = LANES.min(self.count - first);
            for lane in 0..count {
                bundle.set(lane, &ray(first + lane), 0.5);
            }
            self.marcher.enter(simd, &mut bundle);
            (count..LANES).for_each(|lane| bundle.stop(lane));
            *rows = start(&bundle);
        }
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
            let n = self.gather(simd, field.decoder().shading, scratch);
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
            self.composite(channels, n, scratch);
        }
        if let Some(depth) = depth {
            for (depth, gathered) in depth.iter_mut().zip(self.gathered(scratch.rays)) {
                *depth = gathered.expected_depth();
            }
        }
        match field.decoder().shading {
            Shading::PerSample => self.write_sums(scratch, rgba),
            Shading::PerRay => self.shade::<S, T>(simd, field.decoder(), scratch, rgba),
        }
        asked
    }

    /// What each ray has gathered.
    fn gathered<'r>(&self, rays: &'r [Rows]) -> impl Iterator<Item = Gathered> + Clone + 'r {
        let lanes = rays.iter().flat_map(|rows| (0..LANES).map(|lane| gathered(rows, lane)));
        lanes.take(self.count)
    }

    /// Fills a batch with the next samples of the living rays; gives their number.
    fn gather<S: Simd>(&self, simd: S, shading: Shading, scratch: &mut Scratch<'_>) -> usize {
        let Scratch { rays, points: [x, y, z], directions, t, owners, .. } = scratch;
        let rays = &mut rays[..self.count.div_ceil(LANES)];
        let alive = |rows: &Rows| {
            rows[NEXT]
                .iter()
                .zip(&rows[END])
                .map(|(next, end)| usize::from(next < end))
                .sum::<usize>()
        };
        let all_alive: usize = rays.iter().map(alive).sum();
        let most = (self.most_samples / all_alive.max(1)).clamp(*RUN.start(), *RUN.end());
        let mut n = 0;
        for (number, rows) in rays.iter_mut().enumerate() {
            // Every lane may take all it is allowed.
            let room = most.min((self.most_samples - n) / LANES);
            if room == 0 {
                break;
            }
            if alive(rows) == 0 {
                continue;
            }
            let mut bundle = bundle(rows);
            self.marcher.advance(simd, &mut bundle, room, |lane, distance, u| {
                [x[n], y[n], z[n]] = u;
                t[n] = distance;
                owners[n] = (number * LANES + lane) as f32;
                if shading == Shading::PerSample {
                    for (row, d) in directions.iter_mut().zip(&rows[DIRECTION]) {
                        row[n] = d[lane];
                    }
                }
                n += 1;
            });
            rows[NEXT] = bundle.next;
        }
        n
    }

    /// Adds the batch to its rays; opaque rays end.
    fn composite(&self, channels: usize, n: usize, scratch: &mut Scratch<'_>) {
        let Scratch { work, rays, channels: sums, t, owners, .. } = scratch;
        let (alphas, features) = work.output.split_at(work.stride);
        let min_transmittance = self.model.sampling.min_transmittance;
        for s in 0..n {
            let owner = owners[s] as usize;
            let (rows, lane) = (&mut rays[owner / LANES], owner % LANES);
            let mut gathered = gathered(rows, lane);
            if gathered.transmittance < min_transmittance {
                // It has become opaque within this batch.
                continue;
            }
            let weight = gathered.add(alphas[s], t[s]);
            if weight > 0.0 {
                let sums = &mut sums[owner * channels..][..channels];
                for (sum, row) in sums.iter_mut().zip(features.chunks(work.stride)) {
                    *sum += weight * row[s];
                }
            }
            rows[TRANSMITTANCE][lane] = gathered.transmittance;
            rows[OPACITY][lane] = gathered.opacity;
            rows[DEPTH][lane] = gathered.depth;
            if gathered.transmittance < min_transmittance {
                rows[NEXT][lane] = rows[END][lane];
            }
        }
    }

    /// Per-sample shading: the sums are the colour.
    fn write_sums(&self, scratch: &Scratch<'_>, rgba: &mut [[f32; 4]]) {
        let sums = scratch.channels.as_chunks::<3>().0;
        for ((pixel, gathered), sum) in rgba.iter_mut().zip(self.gathered(scratch.rays)).zip(sums) {
            let alpha = gathered.alpha(self.model.sampling.min_transmittance);
            let scale = if gathered.opacity > 0.0 { alpha / gathered.opacity } else { 0.0 };
            *pixel = [scale * sum[0], scale * sum[1], scale * sum[2], alpha];
        }
    }

    /// Deferred shading: the colour network reads each hit ray's average
    /// features, `rgb = alpha * logistic(net(sum / opacity, direction))`.
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
        let mut n = 0;
        let all = self.gathered(rays).enumerate().zip(sums.chunks_exact(channels));
        for ((i, gathered), sums) in all.filter(|((_, gathered), _)| gathered.opacity > 0.0) {
            for (row, sum) in work.a.chunks_mut(stride).zip(sums) {
                row[n] = sum / gathered.opacity;
            }
            for (row, d) in directions.iter_mut().zip(&rays[i / LANES][DIRECTION]) {
                row[n] = d[i % LANES];
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
        for (gathered, pixel) in self.gathered(rays).zip(rgba) {
            *pixel = [0.0; 4];
            if gathered.opacity > 0.0 {
                let alpha = gathered.alpha(self.model.sampling.min_transmittance);
                let color = |row: usize| work.output[row * stride + column];
                *pixel = [alpha * color(1), alpha * color(2), alpha * color(3), alpha];
                column += 1;
            }
        }
    }
}
