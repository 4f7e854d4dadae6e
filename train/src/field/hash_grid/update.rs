//! A step of all parameters: scatter to the grid, sum the networks' gradients, Adam for
//! the grid, Muon at first for the networks beside it, then Adam.

use std::sync::PoisonError;

use fearless_simd::dispatch;
use pocketnerf_core::encoding::hash_grid::Level as GridLevel;
use rayon::prelude::*;

use super::TrainableHashGrid;
use super::back::GroupGradients;
use crate::aligned::Aligned;
use crate::field::rounding::{EightBits, Half, Rounding};
use crate::field::{Layout, Rounded, Update, sum_groups};
use crate::stopwatch::{Laps, Stage};
use crate::trainer::{Adam, Slices, muon};

/// New networks: by Muon at first, then by Adam.
fn follow(
    (level, layout): (fearless_simd::Level, &Layout),
    (adam, rate, step): (Adam, f32, u32),
    network: Slices<'_, u16>,
) {
    let corrected = adam.corrected(rate, step);
    if step <= muon::STEPS {
        muon::update_all(level, rate, layout, (&adam, corrected), Half, network);
    } else {
        dispatch!(level, simd => adam.update(simd, corrected, Half, network));
    }
}

/// A level of the grid that is to be updated.
struct Task<'p> {
    number: usize,
    shape: GridLevel,
    parameters: &'p mut [f32],
    /// Second moments.
    square: &'p mut [f32],
    /// The parameters, rounded.
    table: &'p mut [u8],
    rounding: &'p mut EightBits,
}

impl TrainableHashGrid {
    pub(super) fn update_parameters(&mut self, update: Update<'_>) {
        let Update { level, parameters, mean, square, step, adam, .. } = update;
        let (stopwatch, rate) = (update.stopwatch, update.rate);
        let Self { config, layout, rounded, groups, gradient, level_gradients, .. } = self;
        let mut laps = Laps::begin(stopwatch);
        let groups: Vec<&GroupGradients> = groups
            .iter_mut()
            .map(|group| &*group.get_mut().unwrap_or_else(PoisonError::into_inner))
            .collect();
        let networks: Vec<&[f32]> = groups.iter().map(|group| &group.networks[..]).collect();
        sum_groups(gradient, &networks);
        laps.end(Stage::Reduce, 1);
        let (grid_p, network_p) = parameters.split_at_mut(layout.networks_start());
        let (grid_v, network_v) = square.split_at_mut(layout.networks_start());
        let Rounded { tables, scales, networks } = rounded;
        let network = Slices {
            parameters: network_p,
            gradient,
            mean,
            square: network_v,
            rounded: &mut networks[..],
        };
        let features = config.grid.n_features_per_level as usize;
        let n_encoded = config.grid.n_output();
        let (mut rest, mut tables) = ([grid_p, grid_v], &mut tables[..]);
        let mut tasks: Vec<Task<'_>> = Vec::with_capacity(layout.tables().len());
        for ((number, range), rounding) in layout.tables().iter().enumerate().zip(scales) {
            let [parameters, square] =
                rest.each_mut().map(|slice| slice.split_off_mut(..range.len()).unwrap_or_default());
            let table = tables.split_off_mut(..range.len()).unwrap_or_default();
            let shape = config.grid.level(number);
            tasks.push(Task { number, shape, parameters, square, table, rounding });
        }
        // Fine levels, which take longest, first.
        tasks.reverse();
        let grid_adam = Adam { beta1: 0.0, decay: update.table_decay, ..adam };
        let grid_rate = grid_adam.corrected(update.table_rate, step);
        let largest_level = layout.tables().iter().map(|l| l.len()).max().unwrap_or(0);
        let update_networks = || {
            let mut laps = Laps::begin(stopwatch);
            follow((level, layout), (adam, rate, step), network);
            laps.end(Stage::Adam, 0);
        };
        let update_level = |task: Task<'_>| {
            let Task { number, shape, parameters, square, table: rounded, rounding } = task;
            let mut laps = Laps::begin(stopwatch);
            // Adam leaves the buffer zeroed.
            let mut buffer = level_gradients.lease(|| Aligned::new(largest_level));
            let gradient = &mut buffer[..parameters.len()];
            dispatch!(level, simd => {
                for group in &groups {
                    group.scatter(simd, (number, &shape), [features, n_encoded], gradient);
                }
                laps.end(Stage::Scatter, 0);
                let slices = Slices { parameters, gradient, mean: &mut [], square, rounded };
                let largest = grid_adam.update(simd, grid_rate, *rounding, slices);
                if rounding.hold(largest) {
                    rounding.round_all(simd, parameters, rounded);
                }
                laps.end(Stage::Adam, 0);
            });
        };
        let update_grid = || tasks.into_par_iter().with_max_len(1).for_each(update_level);
        rayon::join(update_networks, update_grid);
    }

    /// The groups' gradients, summed up as the update would see them.
    #[cfg(test)]
    pub(super) fn summed(&self, level: fearless_simd::Level) -> Vec<f32> {
        let Self { config, layout, groups, .. } = self;
        let sizes = [config.grid.n_features_per_level as usize, config.grid.n_output()];
        let mut gradient = vec![0.0; layout.len()];
        for group in groups {
            let group = group.lock().unwrap();
            let networks = &mut gradient[layout.networks_start()..];
            networks.iter_mut().zip(&group.networks).for_each(|(sum, g)| *sum += g);
            for (l, range) in layout.tables().iter().enumerate() {
                let (shape, to) = (config.grid.level(l), &mut gradient[range.indices()]);
                dispatch!(level, simd => group.scatter(simd, (l, &shape), sizes, to));
            }
        }
        gradient
    }
}
