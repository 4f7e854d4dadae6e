//! Rays in the lanes of a register: where their points lie.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use crate::lanes::LANES;
use crate::march::Sampling;
use crate::march::ray_packet::RayPacket;
use crate::march::ray_state::RayState;
use crate::march::take::{ABREAST, RUN};

/// One value an axis. Not `map`, which the compiler may leave a call of its own,
/// compiled without the vector instructions.
#[inline(always)]
pub(super) fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// The rays of a register.
pub(super) struct RayRegister<S: Simd> {
    pub(super) origin: [S::f32s; 3],
    pub(super) direction: [S::f32s; 3],
    phase: S::f32s,
}

impl<S: Simd> RayRegister<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, packet: &RayPacket, first: usize) -> Self {
        let load =
            |row: &[f32; LANES]| S::f32s::from_slice(simd, &row[first..first + S::f32s::LEN]);
        Self {
            origin: axes(|a| load(&packet.origin[a])),
            direction: axes(|a| load(&packet.direction[a])),
            phase: load(&packet.phase),
        }
    }

    /// Each ray in [`RUN`] lanes, as many as there are.
    #[inline(always)]
    pub(super) fn abreast(simd: S, states: &[RayState; ABREAST]) -> Self {
        Self {
            origin: axes(|a| Self::each(simd, states, |state| state.origin[a])),
            direction: axes(|a| Self::each(simd, states, |state| state.direction[a])),
            phase: Self::each(simd, states, |state| state.phase),
        }
    }

    /// A number of each ray in [`RUN`] lanes.
    #[inline(always)]
    pub(super) fn each(
        simd: S,
        states: &[RayState; ABREAST],
        of: impl Fn(&RayState) -> f32,
    ) -> S::f32s {
        let mut lanes = [0.0; LANES];
        for (lanes, state) in lanes.as_chunks_mut::<RUN>().0.iter_mut().zip(states) {
            *lanes = [of(state); RUN];
        }
        S::f32s::from_slice(simd, &lanes[..S::f32s::LEN])
    }

    /// Distance of step `k`.
    #[inline(always)]
    pub(super) fn distance(&self, k: S::f32s, sampling: &Sampling) -> S::f32s {
        (k + self.phase) * sampling.step + sampling.near
    }

    #[inline(always)]
    pub(super) fn at(&self, t: S::f32s) -> [S::f32s; 3] {
        axes(|a| self.origin[a] + t * self.direction[a])
    }

    /// Whether the points at distances `t` lie in the box.
    #[inline(always)]
    pub(super) fn inside(&self, simd: S, t: S::f32s, [min, max]: &[[f32; 3]; 2]) -> S::mask32s {
        let p = self.at(t);
        let within = |a: usize| {
            p[a].simd_ge(S::f32s::splat(simd, min[a])) & p[a].simd_le(S::f32s::splat(simd, max[a]))
        };
        within(0) & within(1) & within(2)
    }

    /// Distances between which lies every point that, computed in f32, the box
    /// contains: those at which each ray enters and leaves, and a few roundings
    /// more. The first lies beyond the second where a ray misses.
    #[inline(always)]
    pub(super) fn reach(
        &self,
        simd: S,
        [min, max]: &[[f32; 3]; 2],
        near: f32,
        far: f32,
    ) -> [S::f32s; 2] {
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let [zero, always, never] = [splat(0.0), splat(f32::INFINITY), splat(f32::NEG_INFINITY)];
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
