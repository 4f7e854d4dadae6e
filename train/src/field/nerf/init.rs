//! Parameters before training.

use super::{NerfConfig, NerfLayer};
use crate::field::{Layout, Part, Role};
use crate::random::{Random, normal};

/// Fills `parameters` from `seed`: weights uniform with Glorot's variance, as the
/// authors' program has them, in the trunk with He's; biases 0; random frequencies normal.
pub(in crate::field) fn initialize(
    config: &NerfConfig,
    layout: &Layout,
    seed: u64,
    parameters: &mut [f32],
) {
    let is_trunk = |part: Part| {
        [false, true]
            .iter()
            .any(|coarse| NerfLayer::Trunk(part.layer).part(*coarse, part.role) == part)
    };
    for (i, range) in layout.ranges().iter().enumerate() {
        let mut random = Random::new(seed, [0, i as u64, 0]);
        let values = &mut parameters[range.indices()];
        let [n_in, n_out] = range.shape.map(|n| n as f32);
        let half_width = match range.part.role {
            Role::Fixed => {
                let frequencies = config.frequencies().find(|(part, ..)| *part == range.part);
                let deviation = frequencies.map_or(0.0, |(_, _, deviation)| deviation);
                for value in values {
                    *value = round(deviation * normal(&mut random));
                }
                continue;
            }
            Role::Weight if is_trunk(range.part) => (6.0 / n_in).sqrt(),
            Role::Weight => (6.0 / (n_in + n_out)).sqrt(),
            Role::Table | Role::Bias => 0.0,
        };
        for value in values {
            *value = (random.next_f32() * 2.0 - 1.0) * half_width;
        }
    }
}

/// A number that f16 holds exactly: frequencies are never rounded after training.
fn round(value: f32) -> f32 {
    f32::from_bits(value.to_bits() & 0xffff_e000)
}
