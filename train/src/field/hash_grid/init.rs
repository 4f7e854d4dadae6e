//! Parameters before training.

use crate::field::layout::{Layout, Range, Role};
use crate::random::Random;

/// Half width of the uniform distribution of a grid's entries.
const GRID_RANGE: f32 = 1e-4;

/// Fills `parameters` from `seed`: grids uniform in ±1e-4 (Müller et al. 2022,
/// section 4), weights uniform with He's variance, biases 0.
pub(super) fn initialize(layout: &Layout, seed: u64, parameters: &mut [f32]) {
    for (i, range) in layout.ranges().iter().enumerate() {
        let mut random = Random::new(seed, [0, i as u64, 0]);
        let half_width = half_width(range);
        for value in &mut parameters[range.indices()] {
            *value = (random.next_f32() * 2.0 - 1.0) * half_width;
        }
    }
}

fn half_width(range: &Range) -> f32 {
    match range.part.role {
        Role::Table => GRID_RANGE,
        Role::Weight => (6.0 / range.shape[0] as f32).sqrt(),
        Role::Bias | Role::Fixed => 0.0,
    }
}
