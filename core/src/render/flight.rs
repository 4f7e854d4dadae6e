//! Rays on their way, as they lie in the caller's scratch: a line of the cache each.

use crate::composite::{self, Gathered};
use crate::sampler::{Bundle, RUN, Walk};
use crate::scratch::RAY_LEN;

/// A ray in flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    pub(super) walk: Walk,
    pub(super) gathered: Gathered,
    /// Part of the light that passed its last sample.
    pub(super) passed: f32,
    /// The number of its pixel.
    pub(super) pixel: u32,
    /// Samples that will stand for as many steps as the last.
    left: f32,
}

impl Flight {
    /// The ray in a lane of a bundle, which has gathered nothing.
    #[inline(always)]
    pub(super) fn start(bundle: &Bundle, lane: usize, pixel: u32) -> Self {
        let walk = bundle.walk(lane);
        Self { walk, gathered: Gathered::NOTHING, passed: 1.0, pixel, left: 0.0 }
    }

    #[inline(always)]
    pub(super) fn load(from: &[f32; RAY_LEN]) -> Self {
        let [ox, oy, oz, dx, dy, dz, phase, next, end, rest @ ..] = *from;
        let [transmittance, opacity, depth, passed, pixel, steps, left] = rest;
        Self {
            walk: Walk { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end, steps },
            gathered: Gathered { transmittance, opacity, depth },
            passed,
            pixel: pixel.to_bits(),
            left,
        }
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut [f32; RAY_LEN]) {
        let Self { walk, gathered, passed, pixel, left } = self;
        let Walk { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end, steps } = walk;
        let Gathered { transmittance, opacity, depth } = gathered;
        let pixel = f32::from_bits(pixel);
        let (walk, own) = to.split_at_mut(9);
        walk.copy_from_slice(&[ox, oy, oz, dx, dy, dz, phase, next, end]);
        own.copy_from_slice(&[transmittance, opacity, depth, passed, pixel, steps, left]);
    }

    /// How many samples it is to take next, at most `room`. What each stands for
    /// changes after every [`RUN`] samples of a ray and nowhere else: what a ray
    /// gathers does not depend on the rays beside it.
    #[inline(always)]
    pub(super) fn wants(&mut self, [min_transmittance, late]: [f32; 2], room: usize) -> usize {
        let transmittance = self.gathered.transmittance;
        let [needed] =
            composite::samples_needed(&[transmittance], &[self.passed], min_transmittance, room);
        if self.left == 0.0 {
            self.walk.steps = composite::steps(transmittance, late);
            self.left = RUN as f32;
        }
        needed.min(self.left) as usize
    }

    /// Notes how many it has taken.
    #[inline(always)]
    pub(super) fn took(&mut self, n: usize) {
        self.left -= n as f32;
    }
}
