//! A step of all parameters: scatter to the tables, sum the networks' gradients, Adam for
//! the tables, Muon at first for the networks beside it, then Adam.

use std::sync::PoisonError;

use fearless_simd::dispatch;
use pocketnerf_core::{DType, Error, TensorView};
use rayon::prelude::*;

use super::back::GroupGradients;
use super::{Encoding, TrainableEncoded};
use crate::aligned::Aligned;
use crate::field::rounding::{EightBits, Half, Rounding};
use crate::field::{Layout, Range, Rounded, Update, sum_groups};
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

/// Of the way to the mean of its neighbours a value goes so much in a step at most.
const MOST_SMOOTHED: f32 = 0.5;

/// Tables that are updated together.
struct Task<'p> {
    number: usize,
    ranges: &'p [Range],
    parameters: &'p mut [f32],
    /// Second moments.
    square: &'p mut [f32],
    /// The parameters, rounded.
    tables: &'p mut [u8],
    rounding: &'p mut [EightBits],
}

impl Task<'_> {
    /// The tables as the forward pass reads them.
    fn views(&self, exact: bool) -> Result<Vec<TensorView<'_>>, Error> {
        let mut first = 0;
        let views = self.ranges.iter().zip(&*self.rounding).map(|(range, rounding)| {
            let own = first..first + range.len();
            first = own.end;
            match exact {
                true => {
                    let bytes = bytemuck::must_cast_slice(&self.parameters[own]);
                    range.tensor(bytes, DType::F32, 0)
                }
                false => range.tensor(&self.tables[own], DType::I8, rounding.scale_log2()),
            }
        });
        views.collect()
    }
}

impl<E: Encoding> TrainableEncoded<E> {
    pub(super) fn update_parameters(&mut self, update: Update<'_>) {
        let Update { level, parameters, mean, square, step, adam, .. } = update;
        let (stopwatch, rate) = (update.stopwatch, update.rate);
        let Self { config, layout, rounded, groups, gradient, table_gradients, exact, .. } = self;
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
        let (mut rest, mut tables) = ([grid_p, grid_v], &mut tables[..]);
        let mut tasks = Vec::new();
        let of_tasks = layout.tables().chunks(E::TABLES_OF_A_TASK);
        let scales = scales.chunks_mut(E::TABLES_OF_A_TASK);
        for ((number, ranges), rounding) in of_tasks.enumerate().zip(scales) {
            let len = length(ranges);
            let [parameters, square] =
                rest.each_mut().map(|slice| slice.split_off_mut(..len).unwrap_or_default());
            let tables = tables.split_off_mut(..len).unwrap_or_default();
            tasks.push(Task { number, ranges, parameters, square, tables, rounding });
        }
        // Fine levels, which take longest, first.
        tasks.reverse();
        let grid_adam = Adam { beta1: 0.0, decay: update.table_decay, ..adam };
        let grid_rate = grid_adam.corrected(update.table_rate, step);
        let smoothed = (grid_rate * update.table_smoothing).min(MOST_SMOOTHED);
        let longest = tasks.iter().map(|task| task.parameters.len()).max().unwrap_or(0);
        let update_networks = || {
            let mut laps = Laps::begin(stopwatch);
            follow((level, layout), (adam, rate, step), network);
            laps.end(Stage::Adam, 0);
        };
        let update_task = |task: Task<'_>| {
            let mut laps = Laps::begin(stopwatch);
            // Adam leaves the buffer zeroed.
            let mut buffer = table_gradients.lease(|| Aligned::new(longest));
            let gradient = &mut buffer[..task.parameters.len()];
            let views = task.views(*exact).expect("tables that the step has read");
            dispatch!(level, simd => {
                for group in &groups {
                    group.scatter(simd, &config.grid, (task.number, &views), gradient);
                }
            });
            laps.end(Stage::Scatter, 0);
            let Task { number, ranges, parameters, square, tables, rounding, .. } = task;
            let mean: &mut [f32] = &mut [];
            let mut rest = Slices { parameters, gradient, mean, square, rounded: tables };
            for (i, (range, rounding)) in ranges.iter().zip(rounding).enumerate() {
                let Slices { parameters, gradient, mean, square, rounded } =
                    rest.split_off(range.len());
                dispatch!(level, simd => {
                    if smoothed > 0.0 {
                        let table = number * E::TABLES_OF_A_TASK + i;
                        config.grid.smooth(simd, table, smoothed, (&mut *parameters, &*gradient));
                    }
                    let slices =
                        Slices { parameters: &mut *parameters, gradient, mean, square, rounded: &mut *rounded };
                    let largest = grid_adam.update(simd, grid_rate, *rounding, slices);
                    if rounding.hold(largest) {
                        rounding.round_all(simd, parameters, rounded);
                    }
                });
            }
            laps.end(Stage::Adam, 0);
        };
        let update_grid = || tasks.into_par_iter().with_max_len(1).for_each(update_task);
        rayon::join(update_networks, update_grid);
    }

    /// The groups' gradients, summed up as the update would see them.
    #[cfg(test)]
    pub(super) fn summed(&self, level: fearless_simd::Level, parameters: &[f32]) -> Vec<f32> {
        let Self { config, layout, groups, .. } = self;
        let mut gradient = vec![0.0; layout.len()];
        for group in groups {
            let group = group.lock().unwrap();
            let networks = &mut gradient[layout.networks_start()..];
            networks.iter_mut().zip(&group.networks).for_each(|(sum, g)| *sum += g);
            for (number, ranges) in layout.tables().chunks(E::TABLES_OF_A_TASK).enumerate() {
                let views = ranges.iter().map(|range| self.read(parameters, range).unwrap());
                let views: Vec<_> = views.collect();
                let to = ranges[0].start..ranges[0].start + length(ranges);
                let to = &mut gradient[to];
                dispatch!(level, simd => group.scatter(simd, &config.grid, (number, &views), to));
            }
        }
        gradient
    }
}

/// Values of tables.
fn length(ranges: &[Range]) -> usize {
    ranges.iter().map(Range::len).sum()
}
