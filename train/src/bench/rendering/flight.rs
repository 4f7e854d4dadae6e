//! Rays on their way, and the batch that they fill.

use fearless_simd::{Simd, SimdBase};
use pocketnerf_core::composite::{Gathered, samples_needed};
use pocketnerf_core::field::Shading;
use pocketnerf_core::network::panel_len;
use pocketnerf_core::sampler::{Bundle, LANES, Marcher};
use pocketnerf_core::scratch::{Limits, Workspace};
use pocketnerf_core::{Camera, Tile, Tuning};

use crate::aligned::Aligned;

/// Most samples that a ray adds to a batch, as in the renderer.
const RUN: usize = 4;

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

/// The rays of up to sixteen pixels of a tile, from number `first` on.
#[inline(always)]
pub(super) fn rays<S: Simd>(simd: S, camera: &Camera, tile: Tile, first: usize) -> Bundle {
    let mut bundle = Bundle { origin: camera.position().map(|o| [o; LANES]), ..Bundle::EMPTY };
    let [mut columns, mut rows] = [[0.5; LANES]; 2];
    for (i, (column, row)) in (first as u32..).zip(columns.iter_mut().zip(&mut rows)) {
        *column = (tile.x + i % tile.width) as f32 + 0.5;
        *row = (tile.y + i / tile.width) as f32 + 0.5;
    }
    let n = S::f32s::LEN;
    for lane in (0..LANES).step_by(n) {
        let at = |row: &[f32; LANES]| S::f32s::from_slice(simd, &row[lane..lane + n]);
        let directions = camera.directions(simd, at(&columns), at(&rows));
        for (to, direction) in bundle.direction.iter_mut().zip(directions) {
            direction.store_slice(&mut to[lane..lane + n]);
        }
    }
    bundle
}

/// Sixteen rays with what they have gathered.
struct Sixteen {
    bundle: Bundle,
    gathered: [Gathered; LANES],
    /// Light that still passes.
    left: [f32; LANES],
    /// Part of the light that passed the last sample.
    passed: [f32; LANES],
}

impl Sixteen {
    const EMPTY: Self = Self {
        bundle: Bundle::EMPTY,
        gathered: [Gathered::NOTHING; LANES],
        left: [1.0; LANES],
        passed: [1.0; LANES],
    };
}

/// Rays that travel together: those that meet an occupied cell.
#[derive(Default)]
pub(super) struct Flight {
    rays: Vec<Sixteen>,
    pub(super) count: usize,
    /// `[ray][channels]`.
    pub(super) sums: Vec<f32>,
}

impl Flight {
    /// Forgets all rays.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.count = 0;
    }

    /// Adds those of the bundle's rays, which have entered the box, that meet an
    /// occupied cell.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, marcher: &Marcher<'_>, bundle: &Bundle) {
        let mut bundle = *bundle;
        marcher.seek(simd, &mut bundle);
        for lane in (0..LANES).filter(|lane| bundle.next[*lane] < bundle.end[*lane]) {
            if self.count.is_multiple_of(LANES) {
                self.rays.push(Sixteen::EMPTY);
            }
            let to = &mut self.rays[self.count / LANES].bundle;
            let at = self.count % LANES;
            for axis in 0..3 {
                to.origin[axis][at] = bundle.origin[axis][lane];
                to.direction[axis][at] = bundle.direction[axis][lane];
            }
            (to.next[at], to.end[at]) = (bundle.next[lane], bundle.end[lane]);
            self.count += 1;
        }
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
        min_transmittance: f32,
    ) -> usize {
        let Batch { points: [x, y, z], directions, t, owners, .. } = batch;
        let mut n = 0;
        for (number, rays) in self.rays.iter_mut().enumerate() {
            // Every lane may take all it is allowed.
            let room = RUN.min((most_samples - n) / LANES);
            if room == 0 {
                break;
            }
            if rays.bundle.alive() == 0 {
                continue;
            }
            let most = samples_needed(&rays.left, &rays.passed, min_transmittance, room);
            let direction = rays.bundle.direction;
            marcher.advance(simd, &mut rays.bundle, &most, |lane, distance, u| {
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
            let (rays, lane) = (&mut self.rays[owner / LANES], owner % LANES);
            let gathered = &mut rays.gathered[lane];
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
            (rays.left[lane], rays.passed[lane]) = (gathered.transmittance, 1.0 - alphas[s]);
            if gathered.transmittance < min_transmittance {
                rays.bundle.stop(lane);
            }
        }
    }

    /// What each ray has gathered, and its direction.
    pub(super) fn gathered(&self) -> impl Iterator<Item = (Gathered, [f32; 3])> + '_ {
        let lanes = self.rays.iter().flat_map(|rays| {
            let direction = |lane: usize| [0, 1, 2].map(|axis| rays.bundle.direction[axis][lane]);
            (0..LANES).map(move |lane| (rays.gathered[lane], direction(lane)))
        });
        lanes.take(self.count)
    }
}
