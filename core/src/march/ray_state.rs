//! RayRegister' next samples: a few steps of each ray side by side in a register.

use fearless_simd::{Simd, SimdBase, SimdMask};

use crate::lanes::LANES;
use crate::march::marcher::Marcher;
use crate::march::register::RayRegister;
use crate::march::sample_batch::{SampleBatch, candidates};
use crate::march::stride::Cell;
use crate::{Ray, Space};

/// A ray on its way, in the coordinates of its space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayState {
    /// Where the ray starts, local coordinates.
    pub origin: [f32; 3],
    /// Where it goes: a unit vector.
    pub direction: [f32; 3],
    /// Where in its step a sample lies: 0.5 is the middle.
    pub phase: f32,
    /// Number of the next step, a whole number.
    pub next: f32,
    /// One past the last step inside the space, a whole number.
    pub end: f32,
    /// Steps that each sample stands for, a whole number.
    pub steps: f32,
}

impl RayState {
    /// No ray: it has no steps to take.
    pub const EMPTY: Self =
        Self { origin: [0.0; 3], direction: [0.0; 3], phase: 0.5, next: 0.0, end: 0.0, steps: 1.0 };

    /// Whether it has steps left.
    #[inline(always)]
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.next < self.end
    }

    /// The direction of the public ray, a unit vector.
    #[inline(always)]
    #[must_use]
    pub fn public_direction(&self, space: &Space) -> [f32; 3] {
        space.direction(&Ray { origin: self.origin, direction: self.direction })
    }

    /// The local point at distance `t`.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        let (o, d) = (self.origin, self.direction);
        [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
    }

    /// Makes it end.
    #[inline(always)]
    pub fn stop(&mut self) {
        self.next = self.end;
    }
}

/// Samples of a ray that are looked for at a time, hence also the most that are taken.
pub const RUN: usize = 4;
/// RayRegister that are looked after together at most, in the widest registers.
pub(super) const ABREAST: usize = LANES / RUN;
/// The samples of a register.
const NUMBERS: [f32; LANES] =
    [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0];

/// What rays that go abreast are to take, or have taken.
pub(super) type Counts = [usize; ABREAST];

impl Marcher<'_> {
    /// RayRegister that [`take`](Self::take) wants at a time.
    pub(super) const fn abreast<S: Simd>() -> usize {
        S::f32s::LEN / RUN
    }

    /// Looks at the next [`RUN`] samples of each of the first
    /// [`abreast`](Self::abreast) rays, adds those in occupied cells to the batch, at most
    /// so many a ray, and moves the rays on. Gives how many it took of each: none of a ray
    /// that is to [`seek`](Self::seek) its next sample first.
    #[inline(always)]
    pub(super) fn take<S: Simd>(
        &self,
        simd: S,
        walks: &mut [RayState; ABREAST],
        most: &Counts,
        batch: &mut SampleBatch<'_>,
    ) -> Counts {
        let rays = RayRegister::abreast(simd, walks);
        let next = RayRegister::each(simd, walks, |walk| walk.next);
        let end = RayRegister::each(simd, walks, |walk| walk.end);
        let steps = RayRegister::each(simd, walks, |walk| walk.steps);
        let k = S::f32s::from_slice(simd, &NUMBERS[..S::f32s::LEN]) * steps + next;
        let t = rays.distance((k + (steps - 1.0) * 0.5).min(end - 1.0), &self.sampling);
        let u = self.unit(&rays, t);
        let mut there = k.simd_lt(end);
        if let Some(occupancy) = &self.occupancy {
            there &= Cell::around(simd, occupancy, u).is_occupied;
        }
        let mut bits = there.to_bitmask() as u32;
        let found = candidates::<S>(u, t);
        let mut taken = [0; ABREAST];
        for (r, (walk, taken)) in
            walks.iter_mut().zip(&mut taken).enumerate().take(S::f32s::LEN / RUN)
        {
            let (mut own, first) = (bits & 0xf, RUN * r);
            bits >>= RUN;
            let run = own.trailing_ones() as usize;
            if own >> run == 0 || walk.steps > 1.0 {
                *taken = run.min(most[r]);
                batch.accept(&found, first, *taken);
                let seen = if run == 0 || *taken < run || walk.steps > 1.0 { *taken } else { RUN };
                walk.next += seen as f32 * walk.steps;
            } else {
                // Neighbouring steps, some of them in empty cells.
                let mut seen = 0;
                while own != 0 && *taken < most[r] {
                    let lane = own.trailing_zeros() as usize;
                    batch.accept(&found, first + lane, 1);
                    own &= own - 1;
                    *taken += 1;
                    seen = lane + 1;
                }
                walk.next += if own == 0 { RUN } else { seen } as f32;
            }
            walk.next = walk.next.min(walk.end);
        }
        taken
    }
}
