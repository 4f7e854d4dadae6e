//! Marching through occupied cells: every sample of the global grid that lies
//! in an occupied cell, and no other.
//!
//! The positions are those that visiting every step and testing every bit
//! would give; empty cells and blocks are crossed in one stride each, which is
//! rounded down so that it never passes a sample of the next cell. Sixteen rays
//! march in the lanes of registers; products and sums are never fused, so that
//! positions are the same at every SIMD level.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::sampler::MAX_STEPS;
use crate::sampler::bundle::{Bundle, LANES};
use crate::sampler::rays::{Rays, axes};
use crate::sampler::stride::{Cell, Stride};
use crate::space::UnitMap;
use crate::{Model, Occupancy, Sampling, Space};

/// What marching needs of a model.
#[derive(Clone, Copy, Debug)]
pub struct Marcher<'a> {
    occupancy: Option<Occupancy<'a>>,
    space: Space,
    map: UnitMap,
    sampling: Sampling,
    skip: bool,
}

impl<'a> Marcher<'a> {
    /// Marches through `model`; without `skip`, every step is visited and
    /// tested on its own, which gives the same samples more slowly.
    #[must_use]
    pub fn new(model: &Model<'a>, skip: bool) -> Self {
        Self::from_parts(model.occupancy, model.space, model.sampling, skip)
    }

    /// The same, from the parts of a model that matter.
    #[must_use]
    pub fn from_parts(
        occupancy: Option<Occupancy<'a>>,
        space: Space,
        sampling: Sampling,
        skip: bool,
    ) -> Self {
        Self { occupancy, space, map: space.unit_map(), sampling, skip }
    }

    /// Sets `next` and `end` of the bundle's rays: the steps whose samples, at
    /// `phase` of each, the space [contains](Space::contains). Rounding along a
    /// ray goes one way, so that none is missing between the first and the last.
    #[inline(always)]
    pub fn enter<S: Simd>(&self, simd: S, bundle: &mut Bundle) {
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..LANES).step_by(S::f32s::LEN) {
                    self.enter_register(simd, bundle, first);
                }
            },
        );
    }

    #[inline(always)]
    fn enter_register<S: Simd>(&self, simd: S, bundle: &mut Bundle, first: usize) {
        let splat = |v: f32| S::f32s::splat(simd, v);
        let Sampling { step, near, far, .. } = self.sampling;
        let rays = Rays::load(simd, bundle, first);
        let [t0, t1] = rays.reach(simd, &self.space, near, far);
        let hit = t0.simd_le(t1);
        // Start a little outside, then move in.
        let steps = |t: S::f32s| ((t - near) / step).trunc();
        let mut next = hit.select((steps(t0) - 2.0).max(0.0), splat(0.0));
        let mut end = hit.select((steps(t1) + 3.0).min(MAX_STEPS as f32), splat(0.0));
        loop {
            let late = next.simd_lt(end) & self.outside(simd, &rays, next);
            if !late.any_true() {
                break;
            }
            next = late.select(next + 1.0, next);
        }
        loop {
            let early = next.simd_lt(end) & self.outside(simd, &rays, end - 1.0);
            if !early.any_true() {
                break;
            }
            end = early.select(end - 1.0, end);
        }
        next.store_slice(&mut bundle.next[first..first + S::f32s::LEN]);
        end.store_slice(&mut bundle.end[first..first + S::f32s::LEN]);
    }

    /// Moves the bundle's rays on to these depths, or a step or two less: `axis` says
    /// how deep a unit vector is.
    #[inline(always)]
    pub(crate) fn begin_at<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle,
        depths: &[f32; LANES],
        axis: [f32; 3],
    ) {
        let Sampling { step, near, .. } = self.sampling;
        let [x, y, z] = bundle.direction;
        simd.vectorize(
            #[inline(always)]
            || {
                for lane in 0..LANES {
                    let depth = x[lane] * axis[0] + y[lane] * axis[1] + z[lane] * axis[2];
                    let steps = (depths[lane] / depth - near) / step - bundle.phase[lane];
                    // Cut off to a whole number; what is none moves nothing.
                    let k = (steps - 1.0) as i32 as f32;
                    bundle.next[lane] = bundle.next[lane].max(k);
                }
            },
        );
    }

    /// Whether the samples of these steps lie outside the space. Not a closure: as
    /// for [`axes`].
    #[inline(always)]
    fn outside<S: Simd>(&self, simd: S, rays: &Rays<S>, k: S::f32s) -> S::mask32s {
        let t = rays.distance(k, &self.sampling);
        let far = S::f32s::splat(simd, self.sampling.far);
        t.simd_gt(far) | !rays.inside(simd, t, &self.space)
    }

    /// Takes up to `most[lane]` occupied samples (a whole number) from each ray of
    /// the bundle, nearest first: calls `emit` with some of them at a time, no two of
    /// one ray. Each stands for `steps[lane]` steps (a whole number), in whose middle
    /// it lies, or for what is left of them in the space.
    #[inline(always)]
    pub fn advance<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle,
        [most, steps]: [&[f32; LANES]; 2],
        emit: &mut dyn FnMut(&Found),
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..LANES).step_by(S::f32s::LEN) {
                    self.advance_register(simd, bundle, first, [most, steps], emit);
                }
            },
        );
    }

    #[inline(always)]
    fn advance_register<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle,
        first: usize,
        [most, steps]: [&[f32; LANES]; 2],
        emit: &mut dyn FnMut(&Found),
    ) {
        let n = S::f32s::LEN;
        let [zero, one] = [0.0, 1.0].map(|v| S::f32s::splat(simd, v));
        let end = S::f32s::from_slice(simd, &bundle.end[first..first + n]);
        let mut k = S::f32s::from_slice(simd, &bundle.next[first..first + n]);
        let most = S::f32s::from_slice(simd, &most[first..first + n]);
        let steps = S::f32s::from_slice(simd, &steps[first..first + n]);
        let middle = (steps - one) * 0.5;
        let mut left = k.simd_lt(end).select(most, zero);
        if !left.simd_gt(zero).any_true() {
            return;
        }
        let rays = Rays::load(simd, bundle, first);
        let stride = Stride::new(simd, &rays, &self.map, &self.sampling);
        let mut found = Found { lanes: 0, t: [0.0; LANES], u: [[0.0; LANES]; 3] };
        loop {
            let alive = left.simd_gt(zero);
            if !alive.any_true() {
                break;
            }
            let mut t = rays.distance((k + middle).min(end - one), &self.sampling);
            let mut u = self.unit(&rays, t);
            let (occupied, ahead) = self.look(simd, &stride, u, t);
            // What lies ahead in the same cell needs no other look.
            let in_cell = ((ahead - one) / steps).floor() + one;
            let mut run = (occupied & alive).select(in_cell.min(left), zero);
            k = (alive & !occupied).select(k + ahead, k);
            loop {
                let taken = run.simd_gt(zero);
                let bits = taken.to_bitmask();
                if bits == 0 {
                    break;
                }
                found.lanes = (bits as u32) << first;
                t.store_slice(&mut found.t[first..first + n]);
                for (to, u) in found.u.iter_mut().zip(u) {
                    u.store_slice(&mut to[first..first + n]);
                }
                emit(&found);
                k = taken.select(k + steps, k);
                left = taken.select(left - one, left);
                run = taken.select(run - one, run);
                run = k.simd_lt(end).select(run, zero);
                t = rays.distance((k + middle).min(end - one), &self.sampling);
                u = self.unit(&rays, t);
            }
            left = k.simd_lt(end).select(left, zero);
        }
        k.min(end).store_slice(&mut bundle.next[first..first + n]);
    }

    /// Unit coordinates at distances `t`.
    #[inline(always)]
    fn unit<S: Simd>(&self, rays: &Rays<S>, t: S::f32s) -> [S::f32s; 3] {
        let p = rays.at(t);
        axes(|a| (p[a] - self.map.min[a]) * self.map.scale)
    }

    /// Whether there may be something at `u`, at distances `t`, and how many
    /// steps it is to what may be different: all before are the same.
    #[inline(always)]
    fn look<S: Simd>(
        &self,
        simd: S,
        stride: &Stride<S>,
        u: [S::f32s; 3],
        t: S::f32s,
    ) -> (S::mask32s, S::f32s) {
        let one = S::f32s::splat(simd, 1.0);
        let Some(occupancy) = &self.occupancy else {
            return (one.simd_eq(one), one);
        };
        let cell = Cell::around(simd, occupancy, u);
        let occupied = cell.is_occupied;
        if !self.skip {
            return (occupied, one);
        }
        (occupied, stride.steps_to_leave(simd, u, &cell, t))
    }

    /// Moves the bundle's rays on to their next occupied samples, without taking
    /// them; rays that meet none end.
    #[inline(always)]
    pub fn seek<S: Simd>(&self, simd: S, bundle: &mut Bundle) {
        let mut taken = 0;
        self.advance(simd, bundle, [&[1.0; LANES]; 2], &mut |found| taken |= found.lanes);
        for (lane, next) in bundle.next.iter_mut().enumerate() {
            *next -= (taken >> lane & 1) as f32;
        }
    }
}

/// Samples of several rays, at most one of each.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// A bit for every ray: whether it has one.
    lanes: u32,
    /// Distances along the rays; what is in the other lanes means nothing.
    pub t: [f32; LANES],
    /// Unit coordinates, likewise.
    pub u: [[f32; LANES]; 3],
}

impl Found {
    /// Whether every ray has one.
    #[inline(always)]
    #[must_use]
    pub const fn is_full(&self) -> bool {
        self.lanes == (1 << LANES) - 1
    }

    /// The rays that have one.
    #[inline(always)]
    pub fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let mut bits = self.lanes;
        core::iter::from_fn(move || {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        })
    }
}

#[cfg(test)]
mod tests;
