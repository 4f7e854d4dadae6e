//! What a step does to the parameters, and their average at the end.

use fearless_simd::{Simd, dispatch};
use pocketnerf_core::encoding::hash_grid::Level as GridLevel;
use rayon::prelude::*;

use super::muon;
use crate::aligned::Aligned;
use crate::field::rounding::{EightBits, Half, Rounding};
use crate::field::{EncodingConfig, Rounded, scatter_level};
use crate::stopwatch::{Laps, Stage};
use crate::trainer::optim::adam::{Adam, Slices};
use crate::trainer::step::group::{Group, STRIDE};
use crate::trainer::{StepSettings, Trainer};

/// Parameters of the networks whose gradients a task sums up.
const REDUCED: usize = 1 << 14;

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

impl Trainer {
    /// Scatter to the grid, sum the networks' gradients, and a step of each: Adam for
    /// the grid, Muon at first for the networks beside it; Adam for networks alone.
    pub(crate) fn update_parameters(&mut self, settings: &StepSettings) {
        let Self {
            config,
            layout,
            groups,
            parameters,
            gradient,
            mean,
            square,
            rounded,
            adam,
            level,
            ..
        } = self;
        let (level_gradients, stopwatch) = (&self.level_gradients, self.stopwatch.as_ref());
        let mut laps = Laps::begin(stopwatch);
        let start = layout.networks_start();
        let (grid_p, network_p) = parameters.split_at_mut(start);
        let (grid_v, network_v) = square.split_at_mut(start);
        // Each part of it in the order of the groups.
        gradient.par_chunks_mut(REDUCED).enumerate().for_each(|(part, sums)| {
            for group in &*groups {
                let own = group.network_gradient[part * REDUCED..].iter();
                sums.iter_mut().zip(own).for_each(|(sum, g)| *sum += g);
            }
        });
        laps.end(Stage::Reduce, 1);
        let Rounded { tables, scales, networks } = rounded;
        let network = Slices {
            parameters: network_p,
            gradient,
            mean,
            square: network_v,
            rounded: &mut networks[..],
        };
        let rate = config.network_rate * settings.rate;
        let corrected = adam.corrected(rate, self.step);
        let EncodingConfig::HashGrid(grid) = config.field.encoding else {
            if config.orthogonal && self.step <= muon::STEPS {
                muon::update_all(*level, rate, layout, (adam, corrected), network);
                laps.end(Stage::Adam, 0);
                return;
            }
            dispatch!(*level, simd => adam.update(simd, corrected, Half, network));
            laps.end(Stage::Adam, 0);
            return;
        };
        let features = grid.n_features_per_level as usize;
        let n_encoded = grid.n_output();
        let (mut rest, mut tables) = ([grid_p, grid_v], &mut tables[..]);
        let mut tasks: Vec<Task<'_>> = Vec::with_capacity(layout.levels().len());
        for ((number, range), rounding) in layout.levels().iter().enumerate().zip(scales) {
            let [parameters, square] =
                rest.each_mut().map(|slice| slice.split_off_mut(..range.len()).unwrap_or_default());
            let table = tables.split_off_mut(..range.len()).unwrap_or_default();
            let shape = grid.level(number);
            tasks.push(Task { number, shape, parameters, square, table, rounding });
        }
        // Fine levels, which take longest, first.
        tasks.reverse();
        let grid_adam = Adam { beta1: 0.0, decay: settings.decay, ..*adam };
        let grid_rate = grid_adam.corrected(config.grid_rate * settings.rate, self.step);
        let groups = &*groups;
        let largest_level = layout.levels().iter().map(|l| l.len()).max().unwrap_or(0);
        let update_networks = || {
            let mut laps = Laps::begin(stopwatch);
            if self.step <= muon::STEPS {
                muon::update_all(*level, rate, layout, (adam, corrected), network);
            } else {
                dispatch!(*level, simd => adam.update(simd, corrected, Half, network));
            }
            laps.end(Stage::Adam, 0);
        };
        let update_level = |task: Task<'_>| {
            let Task { number, shape, parameters, square, table: rounded, rounding } = task;
            let mut laps = Laps::begin(stopwatch);
            // Adam leaves the buffer zeroed.
            let mut buffer = level_gradients.take(|| Aligned::new(largest_level));
            let gradient = &mut buffer[..parameters.len()];
            dispatch!(*level, simd => {
                scatter_groups(simd, groups, &shape, number, features, n_encoded, gradient);
                laps.end(Stage::Scatter, 0);
                let slices = Slices { parameters, gradient, mean: &mut [], square, rounded };
                let largest = grid_adam.update(simd, grid_rate, *rounding, slices);
                if rounding.hold(largest) {
                    rounding.round_all(simd, parameters, rounded);
                }
                laps.end(Stage::Adam, 0);
            });
            level_gradients.put(buffer);
        };
        let update_grid = || tasks.into_par_iter().with_max_len(1).for_each(update_level);
        rayon::join(update_networks, update_grid);
    }

    /// Adds the parameters to their sum.
    pub(crate) fn accumulate(&mut self) {
        self.sum.resize(self.parameters.len(), 0.0);
        let sums = self.sum.par_chunks_mut(1 << 16).zip(self.parameters.par_chunks(1 << 16));
        sums.for_each(|(sums, parameters)| {
            for (sum, parameter) in sums.iter_mut().zip(parameters) {
                *sum += parameter;
            }
        });
        self.averaged += 1;
    }

    /// Ends the run: the parameters become their average over its last part.
    pub fn finish(&mut self) {
        if self.averaged == 0 {
            return;
        }
        let inverse = 1.0 / self.averaged as f32;
        let sum = std::mem::take(&mut self.sum);
        self.averaged = 0;
        self.set_parameters(|_, parameters| {
            for (parameter, sum) in parameters.iter_mut().zip(&sum) {
                *parameter = sum * inverse;
            }
        });
    }
}

/// Adds what all groups ask of one level, in their order.
#[inline(always)]
pub(crate) fn scatter_groups<S: Simd>(
    simd: S,
    groups: &[Group],
    grid_level: &GridLevel,
    l: usize,
    features: usize,
    n_encoded: usize,
    gradient: &mut [f32],
) {
    for group in groups {
        let blocks = group.blocks.chunks_exact((3 + n_encoded) * STRIDE);
        for (block, &n) in blocks.zip(&group.block_lens) {
            let (points, rows) = block.split_at(3 * STRIDE);
            let points = [0, 1, 2].map(|a| &points[a * STRIDE..][..n]);
            let rows = &rows[l * features * STRIDE..];
            scatter_level(simd, grid_level, features, points, rows, STRIDE, gradient);
        }
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::TrainConfig;

    #[test]
    fn a_run_ends_with_the_mean_of_the_steps_that_count() {
        let mut config = TrainConfig::hash_grid();
        if let EncodingConfig::HashGrid(grid) = &mut config.field.encoding {
            (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
        }
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        config.samples_per_step = 2048;
        let dataset = builtin::dataset(Split::Train, 16);
        let mut trainer = Trainer::new(dataset, config, SimdLevel::detect()).unwrap();
        let settings = |average| StepSettings { average, ..StepSettings::PLAIN };
        // Nothing to average: nothing changes.
        trainer.step(&settings(false));
        let before = trainer.parameters.clone();
        trainer.finish();
        assert_eq!(*trainer.parameters, *before);
        let mut sum = vec![0.0f64; before.len()];
        for average in [true, false, true, true] {
            trainer.step(&settings(average));
            if average {
                for (sum, value) in sum.iter_mut().zip(&*trainer.parameters) {
                    *sum += f64::from(*value);
                }
            }
        }
        let last = trainer.parameters.clone();
        trainer.finish();
        assert_ne!(*trainer.parameters, *last);
        for (value, sum) in trainer.parameters.iter().zip(sum) {
            let mean = sum / 3.0;
            assert!((f64::from(*value) - mean).abs() <= 1e-6 * mean.abs() + 1e-9, "{value} {mean}");
        }
    }
}
