//! Parameters before training.

use super::Encoding;
use crate::field::layout::{Layout, Role};
use crate::random::Random;

/// Fills `parameters` from `seed`: tables uniform between the bounds of each, weights uniform
/// with He's variance, biases 0.
pub(super) fn initialize(grid: &impl Encoding, layout: &Layout, seed: u64, parameters: &mut [f32]) {
    for (i, range) in layout.ranges().iter().enumerate() {
        let mut random = Random::new(seed, [0, i as u64, 0]);
        let half_width = |width: f32| [-width, width];
        let [low, high] = match range.part.role {
            Role::Table => grid.initial_range(range.part.layer),
            Role::Weight => half_width((6.0 / range.shape[0] as f32).sqrt()),
            Role::Bias | Role::Fixed => half_width(0.0),
        };
        let (middle, width) = (0.5 * (low + high), 0.5 * (high - low));
        for value in &mut parameters[range.indices()] {
            *value = middle + (random.next_f32() * 2.0 - 1.0) * width;
        }
    }
}
