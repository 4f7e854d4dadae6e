//! Many ways through a model at once: their samples, in order, with the densities there.

use core::ops::ControlFlow;

use fearless_simd::{Simd, dispatch};

use crate::Ray;
use crate::lanes::LANES;
use crate::march::composite::Accumulated;
use crate::march::{
    Marcher, Output, RayPacket, RaySlot, RaySlots, SampleBatch, SampleRun, SampleSink, march,
};
use crate::query::Probe;
use crate::scratch::{Scratch, Workspace};

impl Probe<'_> {
    /// Takes `n` rays through occupied cells. `start` returns a ray in the model's
    /// coordinates and the most steps that it takes; `see` receives each of its samples,
    /// nearest first, with the distance and sigma there, in the model's units.
    pub(super) fn march(
        &self,
        marcher: &Marcher<'_>,
        n: usize,
        scratch: &mut Scratch<'_>,
        start: impl Fn(usize) -> Option<(Ray, f32)>,
        mut see: impl FnMut(&mut Seen, f32, f32) -> ControlFlow<()>,
    ) {
        let mut next = 0;
        while next < n {
            while next < n && scratch.slots.count + LANES <= self.tuning.rays {
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
                        scratch.slots.push(&packet, lane, number as u32);
                    }
                }
            }
            self.follow(marcher, scratch, &mut see);
        }
    }

    /// Takes the rays of the scratch to their ends.
    fn follow(
        &self,
        marcher: &Marcher<'_>,
        scratch: &mut Scratch<'_>,
        see: &mut impl FnMut(&mut Seen, f32, f32) -> ControlFlow<()>,
    ) {
        let Scratch { work, samples, slots, active, .. } = scratch;
        let active = &mut active[..slots.count];
        active.iter_mut().zip(0..).for_each(|(active, number)| *active = number);
        let mut sink = Answers { slots, see };
        dispatch!(self.level, simd => {
            let field = &self.model.field;
            march(simd, field, Output::Density, marcher, (samples, work), active, &mut sink);
        });
        slots.count = 0;
    }
}

/// What a question knows of a ray.
pub(super) struct Seen {
    /// The ray's number.
    pub(super) number: usize,
    /// The question's own.
    pub(super) accumulated: Accumulated,
}

/// Where the samples of a question go.
struct Answers<'a, 's, F> {
    slots: &'a mut RaySlots<'s>,
    see: &'a mut F,
}

impl<'s, F> SampleSink for Answers<'_, 's, F>
where
    F: FnMut(&mut Seen, f32, f32) -> ControlFlow<()>,
{
    type Queue = RaySlots<'s>;

    #[inline(always)]
    fn queue(&mut self) -> &mut RaySlots<'s> {
        self.slots
    }

    /// Rays end where the question has its answer.
    fn accumulate<S: Simd>(&mut self, _: S, batch: &SampleBatch<'_>, work: &mut Workspace<'_>) {
        let RaySlots { rays, pixels, runs, .. } = &mut *self.slots;
        let (mut run, mut at) = (SampleRun::NONE, 0);
        while let Some((ray, samples)) = run.next(runs, at..batch.len) {
            at = samples.end;
            let mut slot = RaySlot::load(&rays[ray]);
            let mut seen = Seen { number: pixels[ray] as usize, accumulated: slot.accumulated };
            let mut samples = batch.t[samples.clone()].iter().zip(&work.output[samples]);
            if samples.try_for_each(|(t, sigma)| (self.see)(&mut seen, *t, *sigma)).is_break() {
                slot.state.stop();
            }
            slot.accumulated = seen.accumulated;
            slot.store(&mut rays[ray]);
        }
    }
}
