//! What lies around the points of a register, and how far it is to the end of it.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdInt};

use crate::Occupancy;
use crate::lanes::LANES;
use crate::march::Sampling;
use crate::march::register::{RayRegister, axes};
use crate::occupancy::{BLOCK, OCCUPIED, place};
use crate::space::UnitMap;

/// The cube of cells that are alike around each point of a register.
pub(super) struct Cell<S: Simd> {
    pub(super) is_occupied: S::mask32s,
    /// The smallest corner, in cells.
    corner: [S::f32s; 3],
    /// The side, in cells.
    side: S::f32s,
    /// Cells per unit length.
    resolution: f32,
}

impl<S: Simd> Cell<S> {
    #[inline(always)]
    pub(super) fn around(simd: S, occupancy: &Occupancy<'_>, u: [S::f32s; 3]) -> Self {
        let n = S::f32s::LEN;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let resolution = occupancy.resolution() as f32;
        // Inside the box u ≥ 0; rounding errors and NaN go to 0.
        let cell = axes(|a| (u[a] * resolution).max_precise(0.0).min_precise(resolution).floor());
        let inside = axes(|a| cell[a].simd_lt(splat(resolution)));
        let inside = inside[0] & inside[1] & inside[2];
        let whole: [S::u32s; 3] = axes(|a| cell[a].to_int::<S::i32s>().bitcast());
        let [x, y, z] = axes(|a| whole[a] >> BLOCK.trailing_zeros());
        let blocks = occupancy.resolution() / BLOCK;
        let outside = S::u32s::splat(simd, u32::MAX);
        let block = inside.select((z * blocks + y) * blocks + x, outside);
        let cell_place = place(axes(|a| whole[a] & (BLOCK - 1)));
        let (mut number, mut places, mut around) = ([0; LANES], [0; LANES], [0; LANES]);
        block.store_slice(&mut number[..n]);
        cell_place.store_slice(&mut places[..n]);
        for lane in 0..n {
            around[lane] = occupancy.around(number[lane], places[lane]).into();
        }
        let around = S::u32s::from_slice(simd, &around[..n]);
        let is_occupied = (around & u32::from(OCCUPIED)).simd_ge(1);
        let side = around & u32::from(OCCUPIED - 1);
        // Powers of two: all ones above the side's bit.
        let above = !side + 1;
        let corner = axes(|a| to_float::<S>(whole[a] & above));
        let side = to_float::<S>(side);
        Self { is_occupied, corner, side, resolution }
    }
}

/// Whole numbers below 2^31.
#[inline(always)]
fn to_float<S: Simd>(whole: S::u32s) -> S::f32s {
    whole.bitcast::<S::i32s>().to_float()
}

/// How many steps rays need to cross a cell.
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
    pub(super) fn new(simd: S, rays: &RayRegister<S>, map: &UnitMap, sampling: &Sampling) -> Self {
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

    /// Steps to the first sample beyond the cell around unit points `u`, or a
    /// little less; at least 1.
    #[inline(always)]
    pub(super) fn steps_to_leave(
        &self,
        simd: S,
        u: [S::f32s; 3],
        cell: &Cell<S>,
        t: S::f32s,
    ) -> S::f32s {
        let splat = |v: f32| S::f32s::splat(simd, v);
        let along = |a: usize| {
            let face = (self.upper[a] * cell.side + cell.corner[a]) * (1.0 / cell.resolution);
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
