//! The next samples of many rays, brought together in a batch.

use core::ops::Range;

use fearless_simd::Simd;

use crate::march::marcher::Marcher;
use crate::march::ray_packet::{LANES, RayPacket};
use crate::march::ray_state::{ABREAST, RUN, RayState};
use crate::march::sample_batch::SampleBatch;

/// Rays that share batches, each known by a number.
pub trait RayQueue {
    /// Where a ray is, and how many samples it is to take, from 1 to `room`; that of a
    /// ray that has ended does not matter.
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize);

    /// Notes where it is now and which samples of the batch are its own, if any.
    fn advance(&mut self, ray: usize, walk: &RayState, samples: Range<usize>);

    /// Notes its next step.
    fn skip_to(&mut self, ray: usize, next: f32);
}

impl Marcher<'_> {
    /// Adds the next samples of the `active` rays, of which it holds the numbers, to a
    /// batch until that is full or every ray has had its turn. Those that have ended
    /// are struck off `active`; gives how many there are then. A ray may have sought its
    /// next sample instead: an empty batch does not mean that all have ended.
    #[inline(always)]
    pub fn gather<S: Simd>(
        &self,
        simd: S,
        queue: &mut impl RayQueue,
        active: &mut [f32],
        batch: &mut SampleBatch<'_>,
    ) -> usize {
        let abreast = Self::abreast::<S>();
        let mut seekers = Seekers::NONE;
        let (mut seen, mut alive) = (0, 0);
        loop {
            let room = RUN.min((batch.capacity() - batch.len) / abreast);
            let (mut walks, mut wanted) = ([RayState::EMPTY; ABREAST], [0; ABREAST]);
            let first = alive;
            while seen < active.len() && room > 0 && alive - first < abreast {
                let number = active[seen];
                seen += 1;
                let (walk, wants) = queue.next_samples(number as usize, room);
                if walk.is_active() {
                    (walks[alive - first], wanted[alive - first]) = (walk, wants);
                    active[alive] = number;
                    alive += 1;
                }
            }
            let is_over = alive == first;
            if seekers.len + abreast > LANES || is_over && seekers.len > 0 {
                seekers.seek(simd, self, queue);
            }
            if is_over {
                break;
            }
            let mut start = batch.len;
            let taken = self.take(simd, &mut walks, &wanted, batch);
            for ((number, walk), taken) in active[first..alive].iter().zip(&walks).zip(taken) {
                let ray = *number as usize;
                queue.advance(ray, walk, start..start + taken);
                start += taken;
                if taken == 0 {
                    seekers.push(ray, walk);
                }
            }
        }
        active.copy_within(seen.., alive);
        alive + active.len() - seen
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
    fn push(&mut self, ray: usize, walk: &RayState) {
        self.packet.put(self.len, walk);
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
