//! Marching through occupied cells: every sample of the global grid that lies
//! in an occupied cell, and no other.
//!
//! The positions are those that visiting every step and testing every bit
//! would give. Sixteen rays enter the space and seek their first samples side by
//! side; empty cells and blocks are crossed in one stride each, which is rounded
//! down so that it never passes a sample of the next cell. From there on a few
//! steps of each ray are tested together (`take`). Products and sums are never
//! fused, so that positions are the same at every SIMD level.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::lanes::LANES;
use crate::march::MAX_STEPS;
use crate::march::ray_packet::RayPacket;
use crate::march::ray_state::RayState;
use crate::march::register::{RayRegister, axes};
use crate::march::stride::{Cell, Stride};
use crate::space::{Piece, UnitMap};
use crate::{Model, Occupancy, Ray, Sampling, Space};

/// What marching needs of a model.
#[derive(Clone, Copy, Debug)]
pub struct Marcher<'a> {
    pub(super) occupancy: Option<Occupancy<'a>>,
    space: Space,
    pub(super) map: UnitMap,
    pub(super) sampling: Sampling,
    pub(super) skip: bool,
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

    /// Where the rays march.
    #[inline(always)]
    #[must_use]
    pub const fn space(&self) -> &Space {
        &self.space
    }

    /// Makes the packet's rays [local](Space::local), and sets their `next` and `end`:
    /// the steps whose samples, at `phase` of each, the space
    /// [contains](Space::contains). Rounding along a ray goes one way, so that none is
    /// missing between the first and the last.
    #[inline(always)]
    pub fn enter<S: Simd>(&self, simd: S, packet: &mut RayPacket) {
        if self.space.is_bent() {
            for lane in 0..LANES {
                let mut state = packet.state(lane);
                let public = Ray { origin: state.origin, direction: state.direction };
                (state.next, state.end) = (0.0, 0.0);
                self.turn(&public, &mut state);
                packet.put(lane, &state);
            }
            return;
        }
        packet.make_local(&self.space);
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..LANES).step_by(S::f32s::LEN) {
                    self.enter_register(simd, packet, first);
                }
            },
        );
    }

    /// Takes a ray that has no steps left on to the next piece of the public one that has
    /// some, if there is one.
    #[inline(never)]
    pub(super) fn turn(&self, public: &Ray, state: &mut RayState) {
        let Sampling { step, near, far, .. } = self.sampling;
        let at = |k: f32| (k + state.phase) * step + near;
        let begin = at(state.next);
        let piece = if begin <= far { self.space.piece(public, begin) } else { None };
        let Some(Piece { local, end }) = piece else {
            state.stop();
            return;
        };
        // The first step beyond: a little before, then on.
        let mut last = ((end.min(far) - near) / step).min(MAX_STEPS as f32) as i32 as f32 - 2.0;
        last = last.max(state.next);
        while at(last) < end && at(last) <= far && last < MAX_STEPS as f32 {
            last += 1.0;
        }
        *state = RayState { origin: local.origin, direction: local.direction, end: last, ..*state };
    }

    #[inline(always)]
    fn enter_register<S: Simd>(&self, simd: S, packet: &mut RayPacket, first: usize) {
        let splat = |v: f32| S::f32s::splat(simd, v);
        let Sampling { step, near, far, .. } = self.sampling;
        let rays = RayRegister::load(simd, packet, first);
        let [t0, t1] = rays.reach(simd, &self.space.bounds(), near, far);
        let hit = t0.simd_le(t1);
        // Start a little outside, then move in.
        let steps = |t: S::f32s| ((t - near) / step).trunc();
        let mut next = hit.select((steps(t0) - 2.0).max(0.0), splat(0.0));
        let mut end = hit.select((steps(t1) + 3.0).min(MAX_STEPS as f32), splat(0.0));
        // The first step moves on, then the last one back.
        let mut is_last = false;
        loop {
            let k = if is_last { end - 1.0 } else { next };
            let outside = next.simd_lt(end) & self.outside(simd, &rays, k);
            if outside.any_true() {
                match is_last {
                    false => next = outside.select(next + 1.0, next),
                    true => end = outside.select(end - 1.0, end),
                }
            } else if is_last {
                break;
            } else {
                is_last = true;
            }
        }
        next.store_slice(&mut packet.next[first..first + S::f32s::LEN]);
        end.store_slice(&mut packet.end[first..first + S::f32s::LEN]);
    }

    /// Moves the packet's rays on to these depths, or a step or two less: `axis` says
    /// how deep a unit vector is.
    #[inline(always)]
    pub(crate) fn begin_at<S: Simd>(
        &self,
        simd: S,
        packet: &mut RayPacket,
        depths: &[f32; LANES],
        axis: [f32; 3],
    ) {
        let Sampling { step, near, .. } = self.sampling;
        let [x, y, z] = packet.direction;
        simd.vectorize(
            #[inline(always)]
            || {
                for lane in 0..LANES {
                    let depth = x[lane] * axis[0] + y[lane] * axis[1] + z[lane] * axis[2];
                    let steps = (depths[lane] / depth - near) / step - packet.phase[lane];
                    // Cut off to a whole number; what is none moves nothing.
                    let k = (steps - 1.0) as i32 as f32;
                    packet.next[lane] = packet.next[lane].max(k);
                }
            },
        );
    }

    /// Whether the samples of these steps lie outside the space. Not a closure: as
    /// for [`axes`].
    #[inline(always)]
    fn outside<S: Simd>(&self, simd: S, rays: &RayRegister<S>, k: S::f32s) -> S::mask32s {
        let t = rays.distance(k, &self.sampling);
        let far = S::f32s::splat(simd, self.sampling.far);
        t.simd_gt(far) | !rays.inside(simd, t, &self.space.bounds())
    }

    /// Moves the packet's rays on to their next occupied samples; rays that meet none
    /// end.
    #[inline(never)]
    pub fn seek<S: Simd>(&self, simd: S, packet: &mut RayPacket) {
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..LANES).step_by(S::f32s::LEN) {
                    self.seek_register(simd, packet, first);
                }
            },
        );
    }

    #[inline(always)]
    fn seek_register<S: Simd>(&self, simd: S, packet: &mut RayPacket, first: usize) {
        let lanes = first..first + S::f32s::LEN;
        let end = S::f32s::from_slice(simd, &packet.end[lanes.clone()]);
        let mut k = S::f32s::from_slice(simd, &packet.next[lanes.clone()]);
        let mut seeking = k.simd_lt(end);
        if !seeking.any_true() {
            return;
        }
        let steps = S::f32s::from_slice(simd, &packet.steps[lanes.clone()]);
        let middle = (steps - 1.0) * 0.5;
        let rays = RayRegister::load(simd, packet, first);
        let stride = Stride::new(simd, &rays, &self.map, &self.sampling);
        while seeking.any_true() {
            let t = rays.distance((k + middle).min(end - 1.0), &self.sampling);
            let (occupied, ahead) = self.look(simd, &stride, self.unit(&rays, t), t);
            seeking &= !occupied;
            k = seeking.select(k + ahead, k);
            seeking &= k.simd_lt(end);
        }
        k.min(end).store_slice(&mut packet.next[lanes]);
    }

    /// Unit coordinates at distances `t`.
    #[inline(always)]
    pub(super) fn unit<S: Simd>(&self, rays: &RayRegister<S>, t: S::f32s) -> [S::f32s; 3] {
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
}

#[cfg(test)]
mod tests;
