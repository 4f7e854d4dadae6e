//! Rays on their way, as they lie in the caller's scratch: a cache line each.

use core::ops::Range;

use crate::Ray;
use crate::lanes::LANES;
use crate::march::composite::{self, Accumulated};
use crate::march::{RUN, RayPacket, RayQueue, RayState};
use crate::scratch::RAY_LEN;

/// A ray and what it has accumulated beside its channels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySlot {
    pub(crate) state: RayState,
    pub(crate) accumulated: Accumulated,
    /// Part of the light that its last sample let pass.
    pub(crate) last_transmittance: f32,
    /// Samples that will stand for as many steps as the last.
    left: f32,
}

impl RaySlot {
    #[inline(always)]
    pub(crate) fn load(from: &[f32; RAY_LEN]) -> Self {
        let [ox, oy, oz, dx, dy, dz, phase, next, end, rest @ ..] = *from;
        let [transmittance, opacity, depth, last_transmittance, steps, left, _] = rest;
        let (origin, direction) = ([ox, oy, oz], [dx, dy, dz]);
        Self {
            state: RayState { origin, direction, phase, next, end, steps },
            accumulated: Accumulated { transmittance, opacity, depth },
            last_transmittance,
            left,
        }
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f32; RAY_LEN]) {
        let Self { state, accumulated, last_transmittance, left } = self;
        let RayState { origin, direction, phase, next, end, steps } = state;
        let ([ox, oy, oz], [dx, dy, dz]) = (origin, direction);
        let Accumulated { transmittance, opacity, depth } = accumulated;
        let (ray, own) = to.split_at_mut(9);
        ray.copy_from_slice(&[ox, oy, oz, dx, dy, dz, phase, next, end]);
        own[..6].copy_from_slice(&[transmittance, opacity, depth, last_transmittance, steps, left]);
    }

    /// How many samples it needs next, at most `room`. What each stands for changes
    /// after every [`RUN`] samples of a ray and nowhere else: what a ray accumulates does
    /// not depend on the rays beside it.
    #[inline(always)]
    fn next_samples(&mut self, limits: &RayLimits, room: usize) -> usize {
        let transmittance = self.accumulated.transmittance;
        let last = self.last_transmittance;
        let needed = composite::samples_needed(transmittance, last, limits.min_transmittance, room);
        if self.left == 0.0 {
            self.state.steps = composite::steps(transmittance, limits.coarse_step_below);
            self.left = RUN as f32;
        }
        needed.min(self.left) as usize
    }
}

/// Transmittances at which something changes for a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLimits {
    /// Below this a ray ends.
    pub(crate) min_transmittance: f32,
    /// Below this samples stand for several steps.
    pub(crate) coarse_step_below: f32,
}

impl RayLimits {
    /// Rays go on to the end of the space, and each sample stands for one step.
    pub(crate) const NONE: Self = Self { min_transmittance: 0.0, coarse_step_below: 0.0 };
}

/// The samples that a ray has added to a batch, one after another, or what is left of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleRun {
    pub(crate) ray: usize,
    pub(crate) len: usize,
}

impl SampleRun {
    pub(crate) const NONE: Self = Self { ray: 0, len: 0 };

    /// As it is noted at its first sample.
    #[inline(always)]
    const fn pack(self) -> u32 {
        (self.ray * LANES + self.len) as u32
    }

    /// The ray of the first of `samples`, and as many of them as are its own; the next
    /// run's where nothing is left of this one.
    #[inline(always)]
    pub(crate) fn next(
        &mut self,
        runs: &[u32],
        samples: Range<usize>,
    ) -> Option<(usize, Range<usize>)> {
        if samples.is_empty() {
            return None;
        }
        if self.len == 0 {
            let packed = runs[samples.start] as usize;
            *self = Self { ray: packed / LANES, len: packed % LANES };
        }
        let end = samples.end.min(samples.start + self.len);
        self.len -= end - samples.start;
        Some((self.ray, samples.start..end))
    }
}

/// Rays on their way, and whose the samples of a batch are.
pub(crate) struct RaySlots<'s> {
    /// [`RaySlot`]s.
    pub(crate) rays: &'s mut [[f32; RAY_LEN]],
    /// The number of each ray's pixel.
    pub(crate) pixels: &'s mut [u32],
    /// At the first of a ray's samples, a [`SampleRun`].
    pub(crate) runs: &'s mut [u32],
    /// Rays in use.
    pub(crate) count: usize,
    pub(crate) limits: RayLimits,
    /// The public rays, by their pixels' numbers; none where those are the local ones.
    pub(crate) public: Option<&'s dyn Fn(u32) -> Ray>,
}

impl RaySlots<'_> {
    /// Adds the ray in a lane of a packet, which has accumulated nothing.
    #[inline(always)]
    pub(crate) fn push(&mut self, packet: &RayPacket, lane: usize, pixel: u32) {
        let state = packet.state(lane);
        let slot =
            RaySlot { state, accumulated: Accumulated::EMPTY, last_transmittance: 1.0, left: 0.0 };
        slot.store(&mut self.rays[self.count]);
        self.pixels[self.count] = pixel;
        self.count += 1;
    }

    /// The rays in use: each one's pixel and what it has.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, RaySlot)> + Clone {
        let pixels = self.pixels[..self.count].iter().map(|pixel| *pixel as usize);
        pixels.zip(self.rays.iter().map(RaySlot::load))
    }
}

impl RayQueue for RaySlots<'_> {
    #[inline(always)]
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        let mut slot = RaySlot::load(&self.rays[ray]);
        let samples = slot.next_samples(&self.limits, room);
        slot.store(&mut self.rays[ray]);
        (slot.state, samples)
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, state: &RayState, samples: Range<usize>) {
        let mut slot = RaySlot::load(&self.rays[ray]);
        slot.state.next = state.next;
        slot.left -= samples.len() as f32;
        slot.store(&mut self.rays[ray]);
        if !samples.is_empty() {
            self.runs[samples.start] = SampleRun { ray, len: samples.len() }.pack();
        }
    }

    #[inline(always)]
    fn skip_to(&mut self, ray: usize, next: f32) {
        let mut slot = RaySlot::load(&self.rays[ray]);
        slot.state.next = next;
        slot.store(&mut self.rays[ray]);
    }

    fn public(&self, ray: usize) -> Ray {
        let RaySlot { state, .. } = RaySlot::load(&self.rays[ray]);
        let local = Ray { origin: state.origin, direction: state.direction };
        self.public.map_or(local, |public| public(self.pixels[ray]))
    }

    fn turn(&mut self, ray: usize, state: &RayState) {
        let mut slot = RaySlot::load(&self.rays[ray]);
        slot.state = *state;
        slot.store(&mut self.rays[ray]);
    }
}
