//! The next samples of rays: a few steps of each side by side in a register.

use fearless_simd::{Simd, SimdBase, SimdMask};

use crate::lanes::LANES;
use crate::march::RayState;
use crate::march::marcher::Marcher;
use crate::march::register::RayRegister;
use crate::march::sample_batch::{SampleBatch, candidates};
use crate::march::stride::Cell;

/// Samples of a ray that are tested at a time, hence also the most that are taken.
pub const RUN: usize = 4;
/// Rays whose samples are tested together at most, in the widest registers.
pub(super) const ABREAST: usize = LANES / RUN;
/// The samples of a register.
const NUMBERS: [f32; LANES] =
    [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0];

/// What rays that go abreast are to take, or have taken.
pub(super) type Counts = [usize; ABREAST];

impl Marcher<'_> {
    /// Rays that [`take`](Self::take) needs at a time.
    pub(super) const fn abreast<S: Simd>() -> usize {
        S::f32s::LEN / RUN
    }

    /// Tests the next [`RUN`] samples of each of the first
    /// [`abreast`](Self::abreast) rays, adds those in occupied cells to the batch, at most
    /// so many a ray, and moves the rays on. Returns how many it took of each: none of a ray
    /// that is to [`seek`](Self::seek) its next sample first.
    #[inline(always)]
    pub(super) fn take<S: Simd>(
        &self,
        simd: S,
        states: &mut [RayState; ABREAST],
        most: &Counts,
        batch: &mut SampleBatch<'_>,
    ) -> Counts {
        let rays = RayRegister::abreast(simd, states);
        let next = RayRegister::each(simd, states, |state| state.next);
        let end = RayRegister::each(simd, states, |state| state.end);
        let steps = RayRegister::each(simd, states, |state| state.steps);
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
        for (r, (state, taken)) in
            states.iter_mut().zip(&mut taken).enumerate().take(S::f32s::LEN / RUN)
        {
            let (mut own, first) = (bits & 0xf, RUN * r);
            bits >>= RUN;
            let run = own.trailing_ones() as usize;
            if own >> run == 0 || state.steps > 1.0 {
                *taken = run.min(most[r]);
                batch.accept(&found, first, *taken);
                let seen = if run == 0 || *taken < run || state.steps > 1.0 { *taken } else { RUN };
                state.next += seen as f32 * state.steps;
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
                state.next += if own == 0 { RUN } else { seen } as f32;
            }
            state.next = state.next.min(state.end);
        }
        taken
    }
}
