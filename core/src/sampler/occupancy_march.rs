//! Marching through occupied cells: every sample of the global grid that lies
//! in an occupied cell, and no other.
//!
//! The positions are those that visiting every step and testing every bit
//! would give; empty cells and blocks are crossed in one stride each, which is
//! rounded down so that it never passes a sample of the next cell. Sixteen rays
//! march in the lanes of registers; products and sums are never fused, so that
//! positions are the same at every SIMD level.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::occupancy::BLOCK;
use crate::sampler::MAX_STEPS;
use crate::sampler::bundle::{Bundle, LANES};
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
        let outside = |k: S::f32s| {
            let t = rays.distance(k, &self.sampling);
            t.simd_gt(splat(far)) | !rays.inside(simd, t, &self.space)
        };
        loop {
            let late = next.simd_lt(end) & outside(next);
            if !late.any_true() {
                break;
            }
            next = late.select(next + 1.0, next);
        }
        loop {
            let early = next.simd_lt(end) & outside(end - 1.0);
            if !early.any_true() {
                break;
            }
            end = early.select(end - 1.0, end);
        }
        next.store_slice(&mut bundle.next[first..first + S::f32s::LEN]);
        end.store_slice(&mut bundle.end[first..first + S::f32s::LEN]);
    }

    /// Takes up to `most` occupied samples from every ray of the bundle, nearest
    /// first: calls `emit(lane, t, u)` with the distance and the unit coordinates
    /// of each. Samples of one ray come in order, those of different rays mixed.
    #[inline(always)]
    pub fn advance<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle,
        most: usize,
        mut emit: impl FnMut(usize, f32, [f32; 3]),
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..LANES).step_by(S::f32s::LEN) {
                    self.advance_register(simd, bundle, first, most, &mut emit);
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
        most: usize,
        emit: &mut impl FnMut(usize, f32, [f32; 3]),
    ) {
        let n = S::f32s::LEN;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let [zero, one] = [splat(0.0), splat(1.0)];
        let end = S::f32s::from_slice(simd, &bundle.end[first..first + n]);
        let mut k = S::f32s::from_slice(simd, &bundle.next[first..first + n]);
        let mut left = k.simd_lt(end).select(splat(most as f32), zero);
        if !left.simd_gt(zero).any_true() {
            return;
        }
        let rays = Rays::load(simd, bundle, first);
        let stride = Stride::new(simd, &rays, &self.map, &self.sampling);
        let mut lanes = Found { t: [0.0; LANES], u: [[0.0; LANES]; 3] };
        loop {
            let alive = left.simd_gt(zero);
            if !alive.any_true() {
                break;
            }
            let t = rays.distance(k, &self.sampling);
            let p = rays.at(t);
            let u = axes(|a| (p[a] - self.map.min[a]) * self.map.scale);
            let (found, ahead) = match &self.occupancy {
                None => (alive, one),
                Some(occupancy) => {
                    let cell = Cell::around(simd, occupancy, u);
                    let found = cell.is_occupied() & alive;
                    let ahead = if self.skip {
                        found.select(one, stride.steps_to_leave(simd, u, &cell, t))
                    } else {
                        one
                    };
                    (found, ahead)
                }
            };
            let mut bits = found.to_bitmask();
            if bits != 0 {
                t.store_slice(&mut lanes.t[..n]);
                for (to, u) in lanes.u.iter_mut().zip(u) {
                    u.store_slice(&mut to[..n]);
                }
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize % LANES;
                    emit(first + lane, lanes.t[lane], axes(|a| lanes.u[a][lane]));
                    bits &= bits - 1;
                }
            }
            left = found.select(left - 1.0, left);
            k = alive.select(k + ahead, k);
            left = k.simd_lt(end).select(left, zero);
        }
        k.min(end).store_slice(&mut bundle.next[first..first + n]);
    }
}

/// Where the samples lie that a round of steps has found.
struct Found {
    t: [f32; LANES],
    u: [[f32; LANES]; 3],
}

/// One value an axis. Not `map`, which the compiler may leave a call of its own,
/// compiled without the vector instructions.
#[inline(always)]
fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// The rays of a register.
struct Rays<S: Simd> {
    origin: [S::f32s; 3],
    direction: [S::f32s; 3],
    phase: S::f32s,
}

impl<S: Simd> Rays<S> {
    #[inline(always)]
    fn load(simd: S, bundle: &Bundle, first: usize) -> Self {
        let load =
            |row: &[f32; LANES]| S::f32s::from_slice(simd, &row[first..first + S::f32s::LEN]);
        Self {
            origin: axes(|a| load(&bundle.origin[a])),
            direction: axes(|a| load(&bundle.direction[a])),
            phase: load(&bundle.phase),
        }
    }

    /// Distance of step `k`.
    #[inline(always)]
    fn distance(&self, k: S::f32s, sampling: &Sampling) -> S::f32s {
        (k + self.phase) * sampling.step + sampling.near
    }

    #[inline(always)]
    fn at(&self, t: S::f32s) -> [S::f32s; 3] {
        axes(|a| self.origin[a] + t * self.direction[a])
    }

    /// Whether the points at distances `t` lie in the box.
    #[inline(always)]
    fn inside(&self, simd: S, t: S::f32s, space: &Space) -> S::mask32s {
        let Space::Box { min, max } = space;
        let p = self.at(t);
        let within = |a: usize| {
            p[a].simd_ge(S::f32s::splat(simd, min[a])) & p[a].simd_le(S::f32s::splat(simd, max[a]))
        };
        within(0) & within(1) & within(2)
    }

    /// [`Space::reach`]: the first beyond the second where a ray misses.
    #[inline(always)]
    fn reach(&self, simd: S, space: &Space, near: f32, far: f32) -> [S::f32s; 2] {
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let [zero, always, never] = [splat(0.0), splat(f32::INFINITY), splat(f32::NEG_INFINITY)];
        let Space::Box { min, max } = space;
        let (mut t0, mut t1) = (splat(near), splat(far));
        for a in 0..3 {
            let (o, d) = (self.origin[a], self.direction[a]);
            // At a face, the product of distance and direction is no larger.
            let most = (o.abs() + min[a].abs().max(max[a].abs())) * ROUNDING;
            let (low, high) = (splat(min[a]) - most, splat(max[a]) + most);
            let (p, q) = ((low - o) / d, (high - o) / d);
            // Parallel to the slab: inside or never.
            let parallel = d.simd_eq(zero);
            let inside = o.simd_ge(low) & o.simd_le(high);
            let enters = parallel.select(inside.select(never, always), p.min(q));
            let leaves = parallel.select(inside.select(always, never), p.max(q));
            let finite = o.is_finite() & d.is_finite();
            t0 = t0.max(finite.select(enters, always));
            t1 = t1.min(finite.select(leaves, never));
        }
        let hit = t0.simd_le(t1);
        [hit.select(t0 - t0 * ROUNDING, always), hit.select(t1 + t1 * ROUNDING, never)]
    }
}

/// The cell or empty block around each point of a register.
struct Cell<S: Simd> {
    /// Its smallest corner, in cells.
    corner: [S::f32s; 3],
    /// Its side, in cells.
    side: S::f32s,
    /// Cells per unit length.
    resolution: f32,
    /// 0: the block is empty, 1: the cell is, 2: neither.
    kind: S::u32s,
}

impl<S: Simd> Cell<S> {
    #[inline(always)]
    fn around(simd: S, occupancy: &Occupancy<'_>, u: [S::f32s; 3]) -> Self {
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
        let [x, y, z] = axes(|a| whole[a] & (BLOCK - 1));
        let bit = (z * BLOCK + y) * BLOCK + x;
        let (mut number, mut place, mut kind) = ([0; LANES], [0; LANES], [0; LANES]);
        block.store_slice(&mut number[..n]);
        bit.store_slice(&mut place[..n]);
        for lane in 0..n {
            kind[lane] = occupancy.look(number[lane], place[lane]);
        }
        let kind = S::u32s::from_slice(simd, &kind[..n]);
        let empty = kind.simd_eq(0);
        let side = empty.select(splat(BLOCK as f32), splat(1.0));
        let corner = axes(|a| {
            let block = (cell[a] * (1.0 / BLOCK as f32)).floor() * BLOCK as f32;
            empty.select(block, cell[a])
        });
        Self { corner, side, resolution, kind }
    }

    #[inline(always)]
    fn is_occupied(&self) -> S::mask32s {
        self.kind.simd_eq(2)
    }
}

/// How many steps rays need to cross a cell.
struct Stride<S: Simd> {
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
    fn new(simd: S, rays: &Rays<S>, map: &UnitMap, sampling: &Sampling) -> Self {
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
    fn steps_to_leave(&self, simd: S, u: [S::f32s; 3], cell: &Cell<S>, t: S::f32s) -> S::f32s {
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

#[cfg(test)]
mod tests;
