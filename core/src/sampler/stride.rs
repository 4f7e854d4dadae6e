//! What lies around the points of a register, and how far it is to the end of it.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::Occupancy;
use crate::occupancy::BLOCK;
use crate::sampler::Sampling;
use crate::sampler::bundle::LANES;
use crate::sampler::rays::{Rays, axes};
use crate::space::UnitMap;

/// The cubes of cells around the points of a register's rays: what a ray knows
/// until it leaves its cube.
pub(super) struct Cubes<S: Simd> {
    /// As [`Occupancy::cube`] gives them.
    halves: [[u32; LANES]; 2],
    /// Sides of the cubes, in cells.
    side: [f32; LANES],
    /// A step of each ray, not beyond the first outside its cube.
    leave: S::f32s,
}

impl<S: Simd> Cubes<S> {
    /// Of rays that know nothing yet.
    #[inline(always)]
    pub(super) fn unknown(simd: S) -> Self {
        let leave = S::f32s::splat(simd, f32::NEG_INFINITY);
        Self { halves: [[0; LANES]; 2], side: [0.0; LANES], leave }
    }

    /// Whether unit points `u`, at distances `t`, lie in occupied cells, and if not,
    /// how many steps it is to what may be occupied. `k` are the rays' steps; of
    /// those that are not `alive`, nothing is learnt.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        simd: S,
        occupancy: &Occupancy<'_>,
        stride: &Stride<S>,
        alive: S::mask32s,
        (k, t, u): (S::f32s, S::f32s, [S::f32s; 3]),
    ) -> (S::mask32s, S::f32s) {
        let n = S::f32s::LEN;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let resolution = occupancy.resolution() as f32;
        // Inside the box u ≥ 0; rounding errors and NaN go to 0.
        let cell = axes(|a| (u[a] * resolution).max_precise(0.0).min_precise(resolution).floor());
        let whole: [S::u32s; 3] = axes(|a| cell[a].to_int::<S::i32s>().bitcast());
        let new = alive & k.simd_ge(self.leave);
        let mut lanes = new.to_bitmask();
        if lanes != 0 {
            let inside = axes(|a| cell[a].simd_lt(splat(resolution)));
            let inside = inside[0] & inside[1] & inside[2];
            let [x, y, z] = axes(|a| whole[a] >> BLOCK.trailing_zeros());
            let blocks = occupancy.resolution() / BLOCK;
            let outside = S::u32s::splat(simd, u32::MAX);
            let block = inside.select((z * blocks + y) * blocks + x, outside);
            let row = ((whole[1] >> 2) & 1) + ((whole[2] & 4) << 1);
            let mut places = [[0; LANES]; 3];
            for (place, values) in places.iter_mut().zip([block, row, whole[0] & 4]) {
                values.store_slice(&mut place[..n]);
            }
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % LANES;
                lanes &= lanes - 1;
                let [block, row, x] = [0, 1, 2].map(|i| places[i][lane]);
                let ([low, high], side) = occupancy.cube(block, row, x);
                (self.halves[0][lane], self.halves[1][lane], self.side[lane]) = (low, high, side);
            }
            let side = S::f32s::from_slice(simd, &self.side[..n]);
            // Sides are powers of two: nothing is rounded. Where nothing is known, it is
            // not used.
            let corner = axes(|a| (cell[a] / side).floor() * side);
            let ahead = stride.steps_to_leave(simd, u, (corner, side, resolution), t);
            self.leave = new.select(k + ahead, self.leave);
        }
        let [low, high] = [0, 1].map(|i| S::u32s::from_slice(simd, &self.halves[i][..n]));
        let bit = (whole[0] & 3) + ((whole[1] & 3) << 3) + ((whole[2] & 1) << 2);
        let upper = (whole[2] & 2).simd_eq(2);
        let half = upper.select(high, low);
        let is_occupied = ((half >> bit) & 1).simd_eq(1);
        let is_empty = (low | high).simd_eq(0);
        (is_occupied, is_empty.select(self.leave - k, splat(1.0)))
    }
}

/// How many steps rays need to cross a cube of cells.
pub(super) struct Stride<S: Simd> {
    /// Steps per unit length along each axis (infinite where the ray is parallel).
    steps_per_unit: [S::f32s; 3],
    /// 1 where the ray goes up the axis, else 0: which face it leaves through.
    upper: [S::f32s; 3],
    /// Rounding error of a unit coordinate along each axis, in steps: large
    /// where the ray hardly moves along the axis.
    slack: [S::f32s; 3],
    /// Rounding error of a distance, in steps, per unit of distance.
    error: f32,
}

impl<S: Simd> Stride<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rays: &Rays<S>, map: &UnitMap, sampling: &Sampling) -> Self {
        let splat = |v: f32| S::f32s::splat(simd, v);
        let steps_per_unit =
            axes(|a| splat(1.0) / (rays.direction[a] * (map.scale * sampling.step)));
        // A point is a sum of numbers no larger than this, each rounded.
        let rounding = |a: usize| {
            (rays.origin[a].abs() + map.min[a].abs()) * (map.scale * 4.0 * f32::EPSILON)
                + 4.0 * f32::EPSILON
        };
        Self {
            steps_per_unit,
            slack: axes(|a| rounding(a) * steps_per_unit[a].abs()),
            upper: axes(|a| rays.direction[a].simd_gt(splat(0.0)).select(splat(1.0), splat(0.0))),
            error: 8.0 * f32::EPSILON / sampling.step,
        }
    }

    /// Steps to the first sample beyond the cube around unit points `u`, or a
    /// little less; at least 1. Of the cube, its smallest corner and its side, in cells,
    /// and how many cells there are along a unit length.
    #[inline(always)]
    pub(super) fn steps_to_leave(
        &self,
        simd: S,
        u: [S::f32s; 3],
        (corner, side, resolution): ([S::f32s; 3], S::f32s, f32),
        t: S::f32s,
    ) -> S::f32s {
        let splat = |v: f32| S::f32s::splat(simd, v);
        let along = |a: usize| {
            let face = (self.upper[a] * side + corner[a]) * (1.0 / resolution);
            let steps = (face - u[a]) * self.steps_per_unit[a] - self.slack[a];
            // Parallel rays give ±infinity or NaN, and never leave. A negative number
            // means that rounding put `u` on the far side: one step, no more.
            steps.is_finite().select(steps, splat(f32::INFINITY))
        };
        let steps = along(0).min(along(1)).min(along(2));
        let safe = steps - (t * self.error + 0.01);
        // Whole steps, rounded up: the last sample inside is `floor(steps)` away.
        let sound = safe.simd_gt(splat(0.0)) & safe.simd_lt(splat(1e6));
        sound.select(safe.floor() + 1.0, splat(1.0))
    }
}
