//! Rays of a tile on their way, and the batch that they fill.

use fearless_simd::Simd;
use pocketnerf_core::composite::Gathered;
use pocketnerf_core::field::Shading;
use pocketnerf_core::network::panel_len;
use pocketnerf_core::sampler::{Bundle, LANES, Marcher};
use pocketnerf_core::scratch::{Limits, Workspace};
use pocketnerf_core::{Ray, Tuning};

use crate::aligned::Aligned;

/// Fewest and most samples that a ray adds to a batch, as in the renderer.
const RUN: std::ops::RangeInclusive<usize> = 4..=16;

/// A batch of samples; rows are `stride` values apart.
pub(super) struct Batch {
    pub(super) a: Aligned<f32>,
    pub(super) b: Aligned<f32>,
    pub(super) output: Aligned<f32>,
    pub(super) panel: Aligned<f32>,
    pub(super) points: [Aligned<f32>; 3],
    pub(super) directions: [Aligned<f32>; 3],
    t: Aligned<f32>,
    /// The ray that each sample lies on.
    owners: Vec<usize>,
    pub(super) stride: usize,
}

impl Batch {
    pub(super) fn new(limits: Limits, tuning: Tuning) -> Self {
        let stride = tuning.stride();
        let rows = |n: usize| Aligned::new(n * stride);
        Self {
            a: rows(limits.width),
            b: rows(limits.width),
            output: rows(1 + limits.channels),
            panel: Aligned::new(panel_len(limits.width)),
            points: [rows(1), rows(1), rows(1)],
            directions: [rows(1), rows(1), rows(1)],
            t: rows(1),
            owners: vec![0; stride],
            stride,
        }
    }

    /// What the field works in, and the first `n` points and directions.
    pub(super) fn parts(&mut self, n: usize) -> (Workspace<'_>, [&[f32]; 3], [&[f32]; 3]) {
        let Self { a, b, output, panel, points, directions, stride, .. } = self;
        let work = Workspace { a, b, output, panel, stride: *stride };
        (work, first(points, n), first(directions, n))
    }
}

fn first(rows: &[Aligned<f32>; 3], n: usize) -> [&[f32]; 3] {
    [0, 1, 2].map(|axis| &rows[axis][..n])
}

/// Rays that travel together.
#[derive(Default)]
pub(super) struct Flight {
    rays: Vec<Ray>,
    bundles: Vec<Bundle>,
    pub(super) gathered: Vec<Gathered>,
    /// `[ray][channels]`.
    pub(super) sums: Vec<f32>,
    /// Samples that each ray has taken.
    taken: Vec<u32>,
    /// Whether each ray had steps inside the box.
    entered: Vec<bool>,
}

impl Flight {
    /// Puts rays on their way.
    #[inline(always)]
    pub(super) fn start<S: Simd>(
        &mut self,
        simd: S,
        rays: impl Iterator<Item = Ray>,
        channels: usize,
        marcher: &Marcher<'_>,
    ) {
        self.rays.clear();
        self.rays.extend(rays);
        self.bundles.clear();
        for rays in self.rays.chunks(LANES) {
            let mut bundle = Bundle::EMPTY;
            for (lane, ray) in rays.iter().enumerate() {
                bundle.set(lane, ray, 0.5);
            }
            marcher.enter(simd, &mut bundle);
            (rays.len()..LANES).for_each(|lane| bundle.stop(lane));
            self.bundles.push(bundle);
        }
        let n = self.rays.len();
        self.gathered.clear();
        self.gathered.resize(n, Gathered::NOTHING);
        self.sums.clear();
        self.sums.resize(n * channels, 0.0);
    }

    /// Remembers which rays have entered the box; apart, for it is not the
    /// renderer's work.
    pub(super) fn remember(&mut self) {
        self.taken.clear();
        self.taken.resize(self.rays.len(), 0);
        self.entered.clear();
        let lanes = self.bundles.iter().flat_map(|b| b.next.iter().zip(&b.end));
        self.entered.extend(lanes.take(self.rays.len()).map(|(next, end)| next < end));
    }

    /// Fills a batch with the next samples of the living rays; gives their number.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(
        &mut self,
        simd: S,
        marcher: &Marcher<'_>,
        shading: Shading,
        batch: &mut Batch,
        most_samples: usize,
    ) -> usize {
        let alive: usize = self.bundles.iter().map(Bundle::alive).sum();
        let most = (most_samples / alive.max(1)).clamp(*RUN.start(), *RUN.end());
        let Batch { points: [x, y, z], directions, t, owners, .. } = batch;
        let mut n = 0;
        for (number, bundle) in self.bundles.iter_mut().enumerate() {
            // Every lane may take all it is allowed.
            let room = most.min((most_samples - n) / LANES);
            if room == 0 {
                break;
            }
            if bundle.alive() == 0 {
                continue;
            }
            let direction = bundle.direction;
            marcher.advance(simd, bundle, room, |lane, distance, u| {
                [x[n], y[n], z[n]] = u;
                t[n] = distance;
                owners[n] = number * LANES + lane;
                if shading == Shading::PerSample {
                    for (row, d) in directions.iter_mut().zip(&direction) {
                        row[n] = d[lane];
                    }
                }
                n += 1;
            });
        }
        n
    }

    /// Adds the batch, whose opacities are known, to its rays; opaque rays end.
    pub(super) fn composite(
        &mut self,
        batch: &Batch,
        n: usize,
        channels: usize,
        min_transmittance: f32,
    ) {
        let (alphas, features) = batch.output.split_at(batch.stride);
        for s in 0..n {
            let owner = batch.owners[s];
            let gathered = &mut self.gathered[owner];
            if gathered.transmittance < min_transmittance {
                continue;
            }
            let weight = gathered.add(alphas[s], batch.t[s]);
            if weight > 0.0 {
                let sums = &mut self.sums[owner * channels..][..channels];
                for (sum, row) in sums.iter_mut().zip(features.chunks(batch.stride)) {
                    *sum += weight * row[s];
                }
            }
            if gathered.transmittance < min_transmittance {
                self.bundles[owner / LANES].stop(owner % LANES);
            }
        }
    }

    /// Writes down which rays the batch belongs to; apart, like
    /// [`Flight::remember`].
    pub(super) fn count(&mut self, batch: &Batch, n: usize) {
        for owner in &batch.owners[..n] {
            self.taken[*owner] += 1;
        }
    }

    /// The rays with the samples that each has taken, none where it has missed
    /// the box.
    pub(super) fn taken(&self) -> impl Iterator<Item = (&Ray, Option<u32>)> {
        let counts = self.taken.iter().zip(&self.entered).map(|(n, in_box)| in_box.then_some(*n));
        self.rays.iter().zip(counts)
    }
}
