//! A ray on its way through the space.

/// A ray on its way, in the coordinates of its space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayState {
    /// Where the ray starts, local coordinates.
    pub origin: [f32; 3],
    /// Where it goes: a unit vector.
    pub direction: [f32; 3],
    /// Where in its step a sample lies: 0.5 is the middle.
    pub phase: f32,
    /// Number of the next step, a whole number.
    pub next: f32,
    /// One past the last step inside the space, a whole number.
    pub end: f32,
    /// Steps that each sample stands for, a whole number.
    pub steps: f32,
}

impl RayState {
    /// No ray: it has no steps to take.
    pub const EMPTY: Self =
        Self { origin: [0.0; 3], direction: [0.0; 3], phase: 0.5, next: 0.0, end: 0.0, steps: 1.0 };

    /// Whether it has steps left.
    #[inline(always)]
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.next < self.end
    }

    /// The local point at distance `t`.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        let (o, d) = (self.origin, self.direction);
        [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
    }

    /// Makes it end, its later pieces too.
    #[inline(always)]
    pub fn stop(&mut self) {
        (self.next, self.end) = (f32::INFINITY, f32::INFINITY);
    }
}
