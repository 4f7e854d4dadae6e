//! Parameters before training.

use super::{Layout, NerfLayer, NerfPart, Part, Range};
use crate::random::{Random, normal};

/// Half width of the uniform distribution of a grid's entries.
const GRID_RANGE: f32 = 1e-4;

/// Fills `parameters` from `seed`: grids uniform in ±1e-4 (Müller et al. 2022,
/// section 4), weights uniform with He's variance, biases 0. In the paper's field,
/// weights are uniform with Glorot's variance, as its authors' program has them, and
/// random frequencies normal.
pub fn initialize(layout: &Layout, seed: u64, parameters: &mut [f32]) {
    for (i, range) in layout.ranges().iter().enumerate() {
        let mut random = Random::new(seed, [0, i as u64, 0]);
        let values = &mut parameters[range.indices()];
        if let Part::Nerf(NerfPart::Frequencies { deviation, .. }) = range.part {
            for value in values {
                *value = round(deviation * normal(&mut random));
            }
            continue;
        }
        let half_width = half_width(range);
        for value in values {
            *value = (random.next_f32() * 2.0 - 1.0) * half_width;
        }
    }
}

fn half_width(range: &Range) -> f32 {
    let [n_in, n_out] = range.shape.map(|n| n as f32);
    match range.part {
        Part::GridLevel(_) => GRID_RANGE,
        Part::DensityWeight(_) | Part::ColorWeight(_) => (6.0 / n_in).sqrt(),
        Part::Nerf(NerfPart::Network { bias: false, layer, .. }) => match layer {
            NerfLayer::Trunk(_) => (6.0 / n_in).sqrt(),
            _ => (6.0 / (n_in + n_out)).sqrt(),
        },
        Part::DensityBias(_) | Part::ColorBias(_) | Part::Nerf(_) => 0.0,
    }
}

/// A number that f16 holds exactly: frequencies are never rounded after training.
fn round(value: f32) -> f32 {
    f32::from_bits(value.to_bits() & 0xffff_e000)
}
