//! What a step of a GPU is to be like.

use pocketnerf_gpu::training::{NetworkRates, Settings, TableRates};

use super::StepInput;
use crate::trainer::step::group::MIN_TRANSMITTANCE;
use crate::trainer::step::slow_below::SlowBelow;
use crate::trainer::{Adam, muon};

/// The same as the CPU would take; `adam` leads the networks.
pub(super) fn settings<'s>(input: &StepInput<'s>, adam: Adam) -> Settings<'s> {
    let number = input.step + 1;
    let of_tables = Adam { decay: input.table_decay, beta1: 0.0, ..adam };
    let rate = of_tables.corrected(input.table_rate, number);
    let slow = SlowBelow::new(&input.space, input.source.nearest());
    Settings {
        occupancy: input.occupancy,
        step: input.sampling.step,
        min_transmittance: MIN_TRANSMITTANCE,
        coarse_step_below: input.coarse_step_below,
        roulette: input.roulette,
        tables: TableRates {
            rate,
            kept: 1.0 - rate * of_tables.decay,
            new: 1.0 - adam.beta2,
            epsilon: adam.epsilon,
        },
        networks: NetworkRates {
            muon: (number <= muon::STEPS).then_some(input.rate),
            adam: adam.corrected(input.rate, number),
            new: [1.0 - adam.beta1, 1.0 - adam.beta2],
        },
        slow_below: slow.map_or(0.0, |slow| slow.distance()),
        smooth_surfaces: input.smooth_surfaces,
        seed: (input.seed ^ (input.seed >> 32)) as u32,
        number: input.step,
        blur_directions: input.blur_directions,
        between_views: input.between_views,
        average: input.average,
    }
}
