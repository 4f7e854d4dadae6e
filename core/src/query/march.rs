//! Many ways through a model at once: their samples, in order, with the densities there.

use core::ops::ControlFlow;

use fearless_simd::{Simd, dispatch};

use crate::Ray;
use crate::march::{LANES, Marcher, RayPacket, SampleBatch};
use crate::query::Probe;
use crate::query::ask::Wanted;
use crate::render::flight::{Flight, Flights, Run};
use crate::scratch::Scratch;

impl Probe<'_> {
    /// Takes `n` rays through occupied cells. `start` gives a ray in the model's
    /// coordinates and the most steps that it takes; `see` is told each of its samples,
    /// nearest first: the ray, of whose numbers `accumulated` is its own, the distance and
    /// sigma there, in the model's units.
    pub(super) fn march(
        &self,
        marcher: &Marcher<'_>,
        n: usize,
        scratch: &mut Scratch<'_>,
        start: impl Fn(usize) -> Option<(Ray, f32)>,
        mut see: impl FnMut(&mut Flight, f32, f32) -> ControlFlow<()>,
    ) {
        let mut next = 0;
        while next < n {
            let mut count = 0;
            while next < n && count + LANES <= self.tuning.rays {
                let numbers = next..n.min(next + LANES);
                next = numbers.end;
                let (mut packet, mut most) = (RayPacket::EMPTY, [0.0; LANES]);
                for (lane, number) in numbers.clone().enumerate() {
                    if let Some((ray, steps)) = start(number) {
                        packet.set(lane, &ray, 0.5);
                        most[lane] = steps;
                    }
                }
                dispatch!(self.level, simd => {
                    marcher.enter(simd, &mut packet);
                    for (end, most) in packet.end.iter_mut().zip(most) {
                        *end = end.min(most);
                    }
                    marcher.seek(simd, &mut packet);
                });
                for (lane, number) in numbers.enumerate() {
                    if packet.next[lane] < packet.end[lane] {
                        let flight = Flight::start(&packet, lane, number as u32);
                        flight.store(&mut scratch.rays[count]);
                        count += 1;
                    }
                }
            }
            self.follow(marcher, count, scratch, &mut see);
        }
    }

    /// Takes the first `count` rays of the scratch to their ends.
    fn follow(
        &self,
        marcher: &Marcher<'_>,
        count: usize,
        scratch: &mut Scratch<'_>,
        see: &mut impl FnMut(&mut Flight, f32, f32) -> ControlFlow<()>,
    ) {
        let numbers = scratch.active[..count].iter_mut().zip(0u32..);
        numbers.for_each(|(active, number)| *active = number as f32);
        let mut active = count;
        while active > 0 {
            let n = self.gather(marcher, scratch, &mut active);
            if n == 0 {
                // Rays have been seeking, or have ended.
                continue;
            }
            self.ask(Wanted::Density, n, scratch);
            let Scratch { work, rays, t, runs, .. } = &mut *scratch;
            let (mut run, mut at) = (Run { ray: 0, len: 0 }, 0);
            while let Some((ray, samples)) = run.next(runs, at..n) {
                at = samples.end;
                let mut flight = Flight::load(&rays[ray]);
                let mut samples = t[samples.clone()].iter().zip(&work.output[samples]);
                if samples.try_for_each(|(t, sigma)| see(&mut flight, *t, *sigma)).is_break() {
                    flight.walk.stop();
                }
                flight.store(&mut rays[ray]);
            }
        }
    }

    /// Fills a batch with the next samples of the active rays; gives their number.
    fn gather(
        &self,
        marcher: &Marcher<'_>,
        scratch: &mut Scratch<'_>,
        active: &mut usize,
    ) -> usize {
        let Scratch { rays, points: [x, y, z], t, runs, active: numbers, .. } = scratch;
        let rows = [x, y, z, t].map(|row| &mut row[..self.tuning.samples]);
        let mut batch = SampleBatch { rows, len: 0 };
        // No ray ends early of its own accord, and each sample stands for one step.
        let (limits, space) = ([0.0; 2], &self.model.space);
        let mut flights = Flights { rays, runs, directions: None, space, limits };
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || *active = marcher.gather(simd, &mut flights, &mut numbers[..*active], &mut batch),
        ));
        batch.len
    }
}
