//! Rays on their way, as they lie in the caller's scratch: a line of the cache each.

use core::ops::Range;

use crate::Space;
use crate::march::composite::{self, Accumulated};
use crate::march::{LANES, RUN, RayPacket, RayQueue, RayState};
use crate::scratch::RAY_LEN;

/// A ray in flight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    pub(crate) walk: RayState,
    pub(crate) accumulated: Accumulated,
    /// Part of the light that passes its last sample.
    pub(crate) last_transmittance: f32,
    /// The number of its pixel.
    pub(crate) pixel: u32,
    /// Samples that will stand for as many steps as the last.
    left: f32,
}

impl Flight {
    /// The ray in a lane of a packet, which has accumulated nothing.
    #[inline(always)]
    pub(crate) fn start(packet: &RayPacket, lane: usize, pixel: u32) -> Self {
        let walk = packet.state(lane);
        Self { walk, accumulated: Accumulated::EMPTY, last_transmittance: 1.0, pixel, left: 0.0 }
    }

    #[inline(always)]
    pub(crate) fn load(from: &[f32; RAY_LEN]) -> Self {
        let [ox, oy, oz, dx, dy, dz, phase, next, end, rest @ ..] = *from;
        let [transmittance, opacity, depth, last_transmittance, pixel, steps, left] = rest;
        Self {
            walk: RayState {
                origin: [ox, oy, oz],
                direction: [dx, dy, dz],
                phase,
                next,
                end,
                steps,
            },
            accumulated: Accumulated { transmittance, opacity, depth },
            last_transmittance,
            pixel: pixel.to_bits(),
            left,
        }
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f32; RAY_LEN]) {
        let Self { walk, accumulated, last_transmittance, pixel, left } = self;
        let RayState { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end, steps } =
            walk;
        let Accumulated { transmittance, opacity, depth } = accumulated;
        let pixel = f32::from_bits(pixel);
        let (walk, own) = to.split_at_mut(9);
        walk.copy_from_slice(&[ox, oy, oz, dx, dy, dz, phase, next, end]);
        own.copy_from_slice(&[
            transmittance,
            opacity,
            depth,
            last_transmittance,
            pixel,
            steps,
            left,
        ]);
    }

    /// How many samples it is to take next, at most `room`. What each stands for
    /// changes after every [`RUN`] samples of a ray and nowhere else: what a ray
    /// gathers does not depend on the rays beside it.
    #[inline(always)]
    pub(crate) fn next_samples(
        &mut self,
        [min_transmittance, late]: [f32; 2],
        room: usize,
    ) -> usize {
        let transmittance = self.accumulated.transmittance;
        let [needed] = composite::samples_needed(
            &[transmittance],
            &[self.last_transmittance],
            min_transmittance,
            room,
        );
        if self.left == 0.0 {
            self.walk.steps = composite::steps(transmittance, late);
            self.left = RUN as f32;
        }
        needed.min(self.left) as usize
    }

    /// Notes how many it has taken.
    #[inline(always)]
    pub(crate) fn advance(&mut self, n: usize) {
        self.left -= n as f32;
    }
}

/// What is left of the samples that a ray has added to a batch, one after another.
#[derive(Clone, Copy)]
pub(crate) struct Run {
    pub(crate) ray: usize,
    pub(crate) len: usize,
}

impl Run {
    /// As it is written down at its first sample.
    #[inline(always)]
    fn bits(self) -> f32 {
        f32::from_bits((self.ray * LANES + self.len) as u32)
    }

    /// Whose the samples from the first on are, and as many of them as there are; the next
    /// run's where nothing is left of this one.
    #[inline(always)]
    pub(crate) fn next(
        &mut self,
        runs: &[f32],
        samples: Range<usize>,
    ) -> Option<(usize, Range<usize>)> {
        if samples.is_empty() {
            return None;
        }
        if self.len == 0 {
            let bits = runs[samples.start].to_bits() as usize;
            *self = Self { ray: bits / LANES, len: bits % LANES };
        }
        let end = samples.end.min(samples.start + self.len);
        self.len -= end - samples.start;
        Some((self.ray, samples.start..end))
    }
}

/// Rays in flight, and what is written down of a batch's samples.
pub(crate) struct Flights<'s, 'f> {
    pub(crate) rays: &'f mut [[f32; RAY_LEN]],
    /// At the first of a ray's samples: whose they are, and how many.
    pub(crate) runs: &'f mut [f32],
    /// Where samples want directions.
    pub(crate) directions: Option<&'f mut [&'s mut [f32]; 3]>,
    pub(crate) space: &'f Space,
    /// Where rays end, and from where samples are late.
    pub(crate) limits: [f32; 2],
}

impl RayQueue for Flights<'_, '_> {
    #[inline(always)]
    fn next_samples(&mut self, ray: usize, room: usize) -> (RayState, usize) {
        let mut flight = Flight::load(&self.rays[ray]);
        let wants = flight.next_samples(self.limits, room);
        flight.store(&mut self.rays[ray]);
        (flight.walk, wants)
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, walk: &RayState, samples: Range<usize>) {
        let mut flight = Flight::load(&self.rays[ray]);
        flight.walk.next = walk.next;
        flight.advance(samples.len());
        flight.store(&mut self.rays[ray]);
        if !samples.is_empty() {
            self.runs[samples.start] = Run { ray, len: samples.len() }.bits();
        }
        if let Some(rows) = &mut self.directions {
            for (row, d) in rows.iter_mut().zip(walk.public_direction(self.space)) {
                row[samples.clone()].fill(d);
            }
        }
    }

    #[inline(always)]
    fn skip_to(&mut self, ray: usize, next: f32) {
        let mut flight = Flight::load(&self.rays[ray]);
        flight.walk.next = next;
        flight.store(&mut self.rays[ray]);
    }
}
