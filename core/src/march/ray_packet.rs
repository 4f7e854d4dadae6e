//! Rays that march side by side.

use crate::lanes::LANES;
use crate::march::ray_state::RayState;
use crate::{Ray, Space};

/// Sixteen rays and the steps they still have to take, coordinate by coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayPacket {
    /// Where each ray starts: scene units, [local](Space::local) ones once it has
    /// entered.
    pub origin: [[f32; LANES]; 3],
    /// Where it goes: unit vectors.
    pub direction: [[f32; LANES]; 3],
    /// Where in its step a sample lies: 0.5 is the middle.
    pub phase: [f32; LANES],
    /// Number of the next step, a whole number.
    pub next: [f32; LANES],
    /// One past the last step inside the space, a whole number.
    pub end: [f32; LANES],
    /// Steps that each sample stands for, a whole number.
    pub steps: [f32; LANES],
}

impl RayPacket {
    /// No rays: none has steps to take.
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        phase: [0.5; LANES],
        next: [0.0; LANES],
        end: [0.0; LANES],
        steps: [1.0; LANES],
    };

    /// Puts a ray into a lane; [`enter`](super::Marcher::enter) finds its steps.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray, phase: f32) {
        for a in 0..3 {
            self.origin[a][lane] = ray.origin[a];
            self.direction[a][lane] = ray.direction[a];
        }
        self.phase[lane] = phase;
    }

    /// Public rays become local ones; those that never enter the space, numbers that
    /// are none.
    #[inline(always)]
    pub(super) fn make_local(&mut self, space: &Space) {
        if space.scene_box().is_some() {
            // They are already.
            return;
        }
        for lane in 0..LANES {
            let [origin, direction] =
                [&self.origin, &self.direction].map(|rows| [0, 1, 2].map(|a| rows[a][lane]));
            let nowhere = Ray { origin, direction: [f32::NAN; 3] };
            let ray = space.local(&Ray { origin, direction }).unwrap_or(nowhere);
            self.set(lane, &ray, self.phase[lane]);
        }
    }

    /// The ray of a lane on its own.
    #[inline(always)]
    #[must_use]
    pub fn state(&self, lane: usize) -> RayState {
        let Self { origin: [ox, oy, oz], direction: [dx, dy, dz], phase, next, end, steps } = self;
        RayState {
            origin: [ox[lane], oy[lane], oz[lane]],
            direction: [dx[lane], dy[lane], dz[lane]],
            phase: phase[lane],
            next: next[lane],
            end: end[lane],
            steps: steps[lane],
        }
    }

    /// Puts a ray on its way into a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, state: &RayState) {
        for a in 0..3 {
            self.origin[a][lane] = state.origin[a];
            self.direction[a][lane] = state.direction[a];
        }
        self.phase[lane] = state.phase;
        self.next[lane] = state.next;
        self.end[lane] = state.end;
        self.steps[lane] = state.steps;
    }

    /// Makes a lane's ray end.
    #[inline(always)]
    pub fn stop(&mut self, lane: usize) {
        self.next[lane] = self.end[lane];
    }

    /// Rays that have steps left.
    #[inline(always)]
    #[must_use]
    pub fn n_active(&self) -> usize {
        self.next.iter().zip(&self.end).map(|(next, end)| usize::from(next < end)).sum()
    }
}
