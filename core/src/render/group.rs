//! Rays that travel together, from start to pixel.

use core::ops::Range;

use fearless_simd::Simd;

use crate::Model;
use crate::composite;
use crate::field::{Field, Samples, Shading};
use crate::lanes::{self, ROWS};
use crate::render::flight::{self, Rows};
use crate::render::observe::{Observer, Stage};
use crate::render::source::Source;
use crate::sampler::{Bundle, LANES, Marcher};
use crate::scratch::{Scratch, Tuning, sums_len};
use crate::store::Store;

/// Rays that travel together.
pub(super) struct Group<'m, 's, 'o, 'f> {
    pub(super) model: &'m Model<'m>,
    pub(super) marcher: Marcher<'m>,
    pub(super) tuning: Tuning,
    pub(super) min_transmittance: f32,
    pub(super) late: f32,
    pub(super) scratch: Scratch<'s>,
    /// Rays on their way.
    pub(super) count: usize,
    /// Rays cast.
    pub(super) rays: u64,
    /// Samples at which the field was asked.
    pub(super) samples: u64,
    pub(super) observer: Option<&'o mut Observer<'f>>,
}

impl Group<'_, '_, '_, '_> {
    /// Whether sixteen more rays might not find room.
    #[inline(always)]
    pub(super) const fn is_full(&self) -> bool {
        self.count + LANES > self.tuning.rays
    }

    /// Tells the observer.
    #[inline(always)]
    pub(super) fn ended(&mut self, stage: Stage, n: usize) {
        if let Some(observer) = &mut self.observer {
            observer(stage, n);
        }
    }

    /// Adds the rays of these numbers, at most sixteen, that meet an occupied
    /// cell; calls `missed` for those that do not. `known` are depths at which they
    /// may begin, and the depth of a unit vector.
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        source: &(impl Source + ?Sized),
        numbers: &[u32],
        known: Option<(&[f32; LANES], [f32; 3])>,
        mut missed: impl FnMut(u32),
    ) {
        let mut bundle = Bundle::EMPTY;
        source.fill(simd, numbers, &mut bundle);
        self.marcher.enter(simd, &mut bundle);
        if let Some((depths, axis)) = known {
            self.marcher.begin_at(simd, &mut bundle, depths, axis);
        }
        (numbers.len()..LANES).for_each(|lane| bundle.stop(lane));
        self.marcher.seek(simd, &mut bundle);
        for (lane, number) in numbers.iter().enumerate() {
            if bundle.next[lane] < bundle.end[lane] {
                let rows = &mut self.scratch.rays[self.count / LANES];
                flight::start(rows, self.count % LANES, &bundle, lane, *number);
                self.count += 1;
            } else {
                missed(*number);
            }
        }
    }

    /// Takes all rays to their ends.
    #[inline(always)]
    pub(super) fn march<S: Simd, T: Store, F: Field>(&mut self, simd: S, field: &F) {
        let channels = field.decoder().channels();
        self.scratch.sums[..self.count * sums_len(channels)].fill(0.0);
        if !self.count.is_multiple_of(LANES) {
            let last = &mut self.scratch.rays[self.count / LANES];
            (self.count % LANES..LANES).for_each(|lane| flight::stop(last, lane));
        }
        let mut living = self.count;
        loop {
            let n = self.gather(simd, field.decoder().shading, living);
            self.ended(Stage::March, n);
            if n == 0 {
                break;
            }
            self.samples += n as u64;
            let padded = n.next_multiple_of(LANES);
            let Scratch { work, points, directions, .. } = &mut self.scratch;
            for row in points.iter_mut().chain(directions.iter_mut()) {
                row[n..padded].fill(0.0);
            }
            let points = [0, 1, 2].map(|axis| &points[axis][..padded]);
            field.encode(simd, points, work.a, work.stride);
            self.ended(Stage::Encode, n);
            let Scratch { work, points, directions, .. } = &mut self.scratch;
            let samples = Samples {
                points: [0, 1, 2].map(|axis| &points[axis][..padded]),
                directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
            };
            field.decoder().density_features::<S, T>(simd, samples, work);
            self.ended(Stage::Density, n);
            let step = self.model.sampling.step;
            composite::opacities(simd, &mut self.scratch.work.output[..padded], step);
            self.composite(simd, channels, n);
            living = self.gather_living(channels, living);
            self.ended(Stage::Composite, n);
        }
    }

    /// The rays in flight.
    pub(super) fn rows(&self) -> &[Rows] {
        &self.scratch.rays[..self.count.div_ceil(LANES)]
    }

    /// Fills a batch with the next samples of the living rays; gives their number.
    fn gather<S: Simd>(&mut self, simd: S, shading: Shading, living: usize) -> usize {
        let Scratch { rays, points: [x, y, z], directions, t, owners, .. } = &mut self.scratch;
        let mut n = 0;
        for (number, rows) in rays[..living.div_ceil(LANES)].iter_mut().enumerate() {
            // Every lane may take all it is allowed.
            let room = flight::RUN.min((self.tuning.samples - n) / LANES);
            if room == 0 {
                break;
            }
            if !flight::any_alive(rows) {
                continue;
            }
            let [most, steps] =
                flight::next_samples(rows, [self.min_transmittance, self.late], room);
            let start = n;
            let mut bundle = flight::bundle(rows);
            let first = (number * LANES) as f32;
            self.marcher.advance(simd, &mut bundle, [&most, &steps], &mut |found| {
                let to = n..n + LANES;
                if found.is_full() && to.end <= x.len() {
                    for (row, values) in [&mut *x, y, z].into_iter().zip(&found.u) {
                        row[to.clone()].copy_from_slice(values);
                    }
                    t[to.clone()].copy_from_slice(&found.t);
                    for (lane, owner) in owners[to].iter_mut().enumerate() {
                        *owner = first + lane as f32;
                    }
                    n += LANES;
                } else {
                    for lane in found.lanes() {
                        [x[n], y[n], z[n]] = [0, 1, 2].map(|a| found.u[a][lane]);
                        t[n] = found.t[lane];
                        owners[n] = first + lane as f32;
                        n += 1;
                    }
                }
            });
            if shading == Shading::PerSample {
                for (row, d) in directions.iter_mut().zip(&rows[flight::DIRECTION]) {
                    for (value, owner) in row[start..n].iter_mut().zip(&owners[start..n]) {
                        *value = d[*owner as usize % LANES];
                    }
                }
            }
            flight::moved(rows, &bundle);
        }
        n
    }

    /// Brings the living among the first `living` rays together, so that bundles
    /// are full; gives their number.
    #[inline(always)]
    fn gather_living(&mut self, channels: usize, living: usize) -> usize {
        let Scratch { rays, sums, .. } = &mut self.scratch;
        let row_len = sums_len(channels);
        flight::gather_living(rays, living, |a, b| {
            for i in 0..row_len {
                sums.swap(a * row_len + i, b * row_len + i);
            }
        })
    }

    /// Adds the batch to its rays; opaque rays end.
    fn composite<S: Simd>(&mut self, simd: S, channels: usize, n: usize) {
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..n).step_by(ROWS) {
                    self.composite_some(simd, channels, first..n.min(first + ROWS));
                }
            },
        );
    }

    /// Adds up to sixteen samples.
    #[inline(always)]
    fn composite_some<S: Simd>(&mut self, simd: S, channels: usize, samples: Range<usize>) {
        let Scratch { work, rays, sums, t, owners, .. } = &mut self.scratch;
        let mut weights = [0.0; ROWS];
        for (s, to) in samples.clone().zip(&mut weights) {
            let owner = owners[s] as usize;
            let (rows, lane) = (&mut rays[owner / LANES], owner % LANES);
            let mut gathered = flight::gathered(rows, lane);
            if gathered.transmittance < self.min_transmittance {
                // It has become opaque within this batch.
                continue;
            }
            let mut alpha = work.output[s];
            let mut steps = flight::steps(rows, lane);
            while steps > 1.0 {
                alpha *= 2.0 - alpha;
                steps *= 0.5;
            }
            *to = gathered.add(alpha, t[s]);
            flight::gather(rows, lane, &gathered, alpha);
            if gathered.transmittance < self.min_transmittance {
                flight::stop(rows, lane);
            }
        }
        let (row_len, first) = (sums_len(channels), samples.start);
        let mut values = [0.0; ROWS * ROWS];
        for part in (0..row_len).step_by(ROWS) {
            let from = &work.output[part * work.stride + first..];
            let from = (from, work.stride, 1 + channels - part);
            lanes::transpose(simd, from, (&mut values, ROWS), ROWS);
            let values = values.as_chunks::<ROWS>().0;
            for ((s, weight), values) in samples.clone().zip(weights).zip(values) {
                if weight > 0.0 {
                    let sums = &mut sums[owners[s] as usize * row_len + part..][..ROWS];
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += weight * value;
                    }
                }
            }
        }
    }
}
