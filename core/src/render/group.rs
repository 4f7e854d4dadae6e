//! Rays that travel together, from start to pixel.

use core::ops::Range;

use fearless_simd::Simd;

use crate::Model;
use crate::field::{Field, Samples};
use crate::lanes::{self, ROWS};
use crate::march::composite;
use crate::march::{LANES, Marcher, RayPacket, SampleBatch};
use crate::render::RenderStats;
use crate::render::flight::{Flight, Flights, Run};
use crate::render::observe::{Observer, Stage};
use crate::render::source::Source;
use crate::scratch::{Scratch, Tuning, sums_len};

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
    /// Rays along which it was.
    pub(super) hits: u64,
    pub(super) observer: Option<&'o mut Observer<'f>>,
}

impl Group<'_, '_, '_, '_> {
    /// What it took so far.
    #[inline(always)]
    pub(super) const fn stats(&self) -> RenderStats {
        RenderStats { rays: self.rays, samples: self.samples, hits: self.hits }
    }

    /// Rays that still find room, up to a packet of them.
    #[inline(always)]
    pub(super) fn room(&self) -> usize {
        LANES.min(self.tuning.rays - self.count)
    }

    /// Whether few more rays find room.
    #[inline(always)]
    pub(super) const fn is_full(&self) -> bool {
        self.count + LANES / 4 > self.tuning.rays
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
        let mut packet = RayPacket::EMPTY;
        source.fill(simd, numbers, &mut packet);
        self.marcher.enter(simd, &mut packet);
        if let Some((depths, axis)) = known {
            self.marcher.begin_at(simd, &mut packet, depths, axis);
        }
        (numbers.len()..LANES).for_each(|lane| packet.stop(lane));
        self.marcher.seek(simd, &mut packet);
        for (lane, number) in numbers.iter().enumerate() {
            if packet.next[lane] < packet.end[lane] {
                let flight = Flight::start(&packet, lane, *number);
                flight.store(&mut self.scratch.rays[self.count]);
                self.count += 1;
            } else {
                missed(*number);
            }
        }
    }

    /// Takes all rays to their ends.
    #[inline(always)]
    pub(super) fn march<S: Simd, F: Field>(&mut self, simd: S, field: &F) {
        let channels = field.channels();
        self.scratch.sums[..self.count * sums_len(channels)].fill(0.0);
        let numbers = self.scratch.active[..self.count].iter_mut().zip(0u32..);
        numbers.for_each(|(active, number)| *active = number as f32);
        let mut active = self.count;
        loop {
            let n = self.gather(simd, field.deferred().is_none(), &mut active);
            self.ended(Stage::March, n);
            if active == 0 {
                break;
            }
            if n == 0 {
                // Rays have been seeking.
                continue;
            }
            self.samples += n as u64;
            let padded = n.next_multiple_of(LANES);
            let Scratch { work, points, directions, .. } = &mut self.scratch;
            for row in points.iter_mut().chain(directions.iter_mut()) {
                row[n..padded].fill(0.0);
            }
            let points = [0, 1, 2].map(|axis| &points[axis][..padded]);
            field.encode(simd, points, work);
            self.ended(Stage::Encode, n);
            let Scratch { work, points, directions, .. } = &mut self.scratch;
            let samples = Samples {
                points: [0, 1, 2].map(|axis| &points[axis][..padded]),
                directions: [0, 1, 2].map(|axis| &directions[axis][..padded]),
            };
            field.decode(simd, samples, work);
            self.ended(Stage::Density, n);
            let step = self.model.sampling.step;
            composite::opacities(simd, &mut self.scratch.work.output[..padded], step);
            self.composite(simd, channels, n);
            self.ended(Stage::Composite, n);
        }
    }

    /// Fills a batch with the next samples of the active rays; gives their number.
    /// Rays that have ended are no longer among the active then. `directed`: with the
    /// samples' directions.
    fn gather<S: Simd>(&mut self, simd: S, directed: bool, active: &mut usize) -> usize {
        let Scratch { rays, points: [x, y, z], directions, t, runs, active: numbers, .. } =
            &mut self.scratch;
        let (most, marcher) = (self.tuning.samples, &self.marcher);
        let (limits, space) = ([self.min_transmittance, self.late], &self.model.space);
        let rows = [x, y, z, t].map(|row| &mut row[..most]);
        let mut batch = SampleBatch { rows, len: 0 };
        simd.vectorize(
            #[inline(always)]
            || {
                let directions = directed.then_some(directions);
                let mut flights = Flights { rays, runs, directions, space, limits };
                let active_rays = &mut numbers[..*active];
                *active = marcher.gather(simd, &mut flights, active_rays, &mut batch);
            },
        );
        batch.len
    }

    /// Adds the batch to its rays; opaque rays end.
    fn composite<S: Simd>(&mut self, simd: S, channels: usize, n: usize) {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut run = Run { ray: 0, len: 0 };
                for first in (0..n).step_by(ROWS) {
                    run = self.composite_some(simd, channels, first..n.min(first + ROWS), run);
                }
            },
        );
    }

    /// Adds up to sixteen samples, the first of which are what is left of a run; gives
    /// what is left of the last.
    #[inline(always)]
    fn composite_some<S: Simd>(
        &mut self,
        simd: S,
        channels: usize,
        samples: Range<usize>,
        run: Run,
    ) -> Run {
        let Scratch { work, rays, sums, t, runs, .. } = &mut self.scratch;
        let mut weights = [0.0; ROWS];
        let mut rest = run;
        let mut at = samples.start;
        while let Some((ray, piece)) = rest.next(runs, at..samples.end) {
            at = piece.end;
            let row = &mut rays[ray];
            let mut flight = Flight::load(row);
            for s in piece {
                if flight.accumulated.transmittance < self.min_transmittance {
                    // It has become opaque within this batch.
                    break;
                }
                let mut alpha = work.output[s];
                let mut steps = flight.walk.steps;
                while steps > 1.0 {
                    alpha *= 2.0 - alpha;
                    steps *= 0.5;
                }
                weights[s - samples.start] = flight.accumulated.add(alpha, t[s]);
                flight.last_transmittance = 1.0 - alpha;
            }
            if flight.accumulated.transmittance < self.min_transmittance {
                flight.walk.stop();
            }
            flight.store(row);
        }
        let row_len = sums_len(channels);
        let mut values = [0.0; ROWS * ROWS];
        for part in (0..row_len).step_by(ROWS) {
            let from = &work.output[part * work.stride + samples.start..];
            let from = (from, work.stride, 1 + channels - part);
            lanes::transpose(simd, from, (&mut values, ROWS), ROWS);
            let values = values.as_chunks::<ROWS>().0;
            let (mut rest, mut at) = (run, samples.start);
            while let Some((ray, piece)) = rest.next(runs, at..samples.end) {
                at = piece.end;
                let sums = &mut sums[ray * row_len + part..][..ROWS];
                for s in piece {
                    let (weight, values) = (weights[s - samples.start], &values[s - samples.start]);
                    // What has no weight may be no number.
                    if weight > 0.0 {
                        for (sum, value) in sums.iter_mut().zip(values) {
                            *sum += weight * value;
                        }
                    }
                }
            }
        }
        rest
    }
}
