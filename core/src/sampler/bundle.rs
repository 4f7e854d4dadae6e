//! Rays that march side by side.

use crate::Ray;

/// Rays in a bundle: the lanes of the widest registers. Narrower ones take a
/// bundle in parts.
pub const LANES: usize = 16;

/// Sixteen rays and the steps they still have to take, coordinate by coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle {
    /// Where each ray starts, scene units.
    pub origin: [[f32; LANES]; 3],
    /// Where it goes: unit vectors.
    pub direction: [[f32; LANES]; 3],
    /// Where in its step a sample lies: 0.5 is the middle.
    pub phase: [f32; LANES],
    /// Number of the next step, a whole number.
    pub next: [f32; LANES],
    /// One past the last step inside the space, a whole number.
    pub end: [f32; LANES],
}

impl Bundle {
    /// No rays: none has steps to take.
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        phase: [0.5; LANES],
        next: [0.0; LANES],
        end: [0.0; LANES],
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

    /// Makes a lane's ray end.
    #[inline(always)]
    pub fn stop(&mut self, lane: usize) {
        self.next[lane] = self.end[lane];
    }

    /// Rays that have steps left.
    #[inline(always)]
    #[must_use]
    pub fn alive(&self) -> usize {
        self.next.iter().zip(&self.end).map(|(next, end)| usize::from(next < end)).sum()
    }
}
