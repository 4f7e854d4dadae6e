//! The next samples of many rays, brought together in a batch.

use core::ops::Range;

use fearless_simd::Simd;

use crate::sampler::batch::Batch;
use crate::sampler::bundle::{Bundle, LANES};
use crate::sampler::occupancy_march::Marcher;
use crate::sampler::walk::{ABREAST, RUN, Walk};

/// Rays that share batches, each known by a number.
pub trait Travellers {
    /// Where a ray is, and how many samples it is to take, from 1 to `room`; that of a
    /// ray that has ended does not matter.
    fn wants(&mut self, ray: usize, room: usize) -> (Walk, usize);

    /// Notes where it is now and which samples of the batch are its own, if any.
    fn took(&mut self, ray: usize, walk: &Walk, samples: Range<usize>);

    /// Notes its next step.
    fn moved(&mut self, ray: usize, next: f32);
}

impl Marcher<'_> {
    /// Adds the next samples of the `living` rays, of which it holds the numbers, to a
    /// batch until that is full or every ray has had its turn. Those that have ended
    /// are struck off `living`; gives how many there are then. A ray may have sought its
    /// next sample instead: an empty batch does not mean that all have ended.
    #[inline(always)]
    pub fn gather<S: Simd>(
        &self,
        simd: S,
        travellers: &mut impl Travellers,
        living: &mut [f32],
        batch: &mut Batch<'_>,
    ) -> usize {
        let abreast = Self::abreast::<S>();
        let mut seekers = Seekers::NONE;
        let (mut seen, mut alive) = (0, 0);
        loop {
            let room = RUN.min((batch.capacity() - batch.len) / abreast);
            let (mut walks, mut wanted) = ([Walk::EMPTY; ABREAST], [0; ABREAST]);
            let first = alive;
            while seen < living.len() && room > 0 && alive - first < abreast {
                let number = living[seen];
                seen += 1;
                let (walk, wants) = travellers.wants(number as usize, room);
                if walk.is_alive() {
                    (walks[alive - first], wanted[alive - first]) = (walk, wants);
                    living[alive] = number;
                    alive += 1;
                }
            }
            let is_over = alive == first;
            if seekers.len + abreast > LANES || is_over && seekers.len > 0 {
                seekers.seek(simd, self, travellers);
            }
            if is_over {
                break;
            }
            let mut start = batch.len;
            let taken = self.take(simd, &mut walks, &wanted, batch);
            for ((number, walk), taken) in living[first..alive].iter().zip(&walks).zip(taken) {
                let ray = *number as usize;
                travellers.took(ray, walk, start..start + taken);
                start += taken;
                if taken == 0 {
                    seekers.push(ray, walk);
                }
            }
        }
        living.copy_within(seen.., alive);
        alive + living.len() - seen
    }
}

/// Rays without a sample where they are: they seek their next ones together.
struct Seekers {
    bundle: Bundle,
    rays: [usize; LANES],
    len: usize,
}

impl Seekers {
    const NONE: Self = Self { bundle: Bundle::EMPTY, rays: [0; LANES], len: 0 };

    #[inline(always)]
    fn push(&mut self, ray: usize, walk: &Walk) {
        self.bundle.put(self.len, walk);
        self.rays[self.len] = ray;
        self.len += 1;
    }

    #[inline(always)]
    fn seek<S: Simd>(&mut self, simd: S, marcher: &Marcher<'_>, travellers: &mut impl Travellers) {
        (self.len..LANES).for_each(|lane| self.bundle.stop(lane));
        marcher.seek(simd, &mut self.bundle);
        for (ray, next) in self.rays.iter().zip(self.bundle.next).take(self.len) {
            travellers.moved(*ray, next);
        }
        self.len = 0;
    }
}
