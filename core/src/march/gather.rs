//! The next samples of many rays, brought together in a batch.

use core::ops::Range;

use fearless_simd::Simd;

use crate::Ray;
use crate::lanes::LANES;
use crate::march::marcher::Marcher;
use crate::march::ray_packet::RayPacket;
use crate::march::ray_state::RayState;
use crate::march::sample_batch::SampleBatch;
use crate::march::take::{ABREAST, RUN};

/// Rays that share batches, each known by a number.
pub trait RayQueue {
    /// Where a ray is, and how many samples it needs next, from 1 to `room`; that of a
    /// ray that has ended does not matter.
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize);

    /// Notes where it is now and which samples of the batch are its own, if any.
    fn advance(&mut self, ray: usize, state: &RayState, samples: Range<usize>);

    /// Notes its next step.
    fn skip_to(&mut self, ray: usize, next: f32);

    /// The public ray, whose direction samples are seen from.
    fn public(&self, ray: usize) -> Ray;

    /// Notes that it goes on along another piece.
    fn turn(&mut self, ray: usize, state: &RayState);
}

impl Marcher<'_> {
    /// Adds the next samples of the `active` rays, of which it holds the numbers, to a
    /// batch until that is full or every ray has had its turn. Those that have ended
    /// are struck off `active`; returns how many there are then. A ray may have sought its
    /// next sample instead: an empty batch does not mean that all have ended.
    #[inline(always)]
    pub fn gather<S: Simd>(
        &self,
        simd: S,
        queue: &mut impl RayQueue,
        active: &mut [u32],
        batch: &mut SampleBatch<'_>,
    ) -> usize {
        let abreast = Self::abreast::<S>();
        let mut seekers = Seekers::NONE;
        let (mut seen, mut n_active) = (0, 0);
        loop {
            let room = RUN.min(batch.room() / abreast);
            let (mut states, mut needed) = ([RayState::EMPTY; ABREAST], [0; ABREAST]);
            let first = n_active;
            while seen < active.len() && room > 0 && n_active - first < abreast {
                let number = active[seen];
                seen += 1;
                let (mut state, mut samples) = queue.next_samples(number as usize, room);
                if self.space().is_bent() && !state.is_active() {
                    self.turn(&queue.public(number as usize), &mut state);
                    queue.turn(number as usize, &state);
                    (state, samples) = queue.next_samples(number as usize, room);
                }
                if state.is_active() {
                    (states[n_active - first], needed[n_active - first]) = (state, samples);
                    active[n_active] = number;
                    n_active += 1;
                }
            }
            let is_over = n_active == first;
            if seekers.len + abreast > LANES || is_over && seekers.len > 0 {
                seekers.seek(simd, self, queue);
            }
            if is_over {
                break;
            }
            let mut start = batch.len;
            let taken = self.take(simd, &mut states, &needed, batch);
            for ((number, state), taken) in active[first..n_active].iter().zip(&states).zip(taken) {
                let ray = *number as usize;
                queue.advance(ray, state, start..start + taken);
                if batch.directed {
                    let is_local = self.space().scene_box().is_some();
                    let seen = if is_local { state.direction } else { queue.public(ray).direction };
                    batch.direct(seen, start, taken);
                }
                start += taken;
                if taken == 0 {
                    seekers.push(ray, state);
                }
            }
        }
        // Not `copy_within`: a microcontroller's `memmove` takes a kilobyte and a half.
        for number in seen..active.len() {
            active.swap(n_active, number);
            n_active += 1;
        }
        n_active
    }
}

/// Rays without a sample where they are: they seek their next ones together.
struct Seekers {
    packet: RayPacket,
    rays: [usize; LANES],
    len: usize,
}

impl Seekers {
    const NONE: Self = Self { packet: RayPacket::EMPTY, rays: [0; LANES], len: 0 };

    #[inline(always)]
    fn push(&mut self, ray: usize, state: &RayState) {
        self.packet.put(self.len, state);
        self.rays[self.len] = ray;
        self.len += 1;
    }

    #[inline(always)]
    fn seek<S: Simd>(&mut self, simd: S, marcher: &Marcher<'_>, queue: &mut impl RayQueue) {
        (self.len..LANES).for_each(|lane| self.packet.stop(lane));
        marcher.seek(simd, &mut self.packet);
        for (ray, next) in self.rays.iter().zip(self.packet.next).take(self.len) {
            queue.skip_to(*ray, next);
        }
        self.len = 0;
    }
}
