//! All that is learnt, in named groups.

use rayon::prelude::*;

use super::Adam;
use super::run::checkpoint::kind;
use crate::aligned::Aligned;
use crate::field::Layout;

/// Parameters that are learnt alike, with what the optimizer and the average keep of each.
#[derive(Clone, Debug)]
pub(crate) struct ParameterGroup {
    /// The parameters.
    pub(crate) parameters: Aligned<f32>,
    /// First moments: of the last so many parameters.
    pub(crate) mean: Vec<f32>,
    /// Second moments.
    pub(crate) square: Aligned<f32>,
    /// Sum of the parameters after [`State::averaged`] steps; empty before the first.
    pub(crate) sum: Vec<f32>,
    /// Constants of its optimizer.
    pub(crate) adam: Adam,
    /// Where a checkpoint holds it.
    pub(crate) sections: GroupSections,
}

/// Kinds of the sections that hold a group in a checkpoint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupSections {
    /// The parameters, where the model does not hold them.
    pub(crate) parameters: Option<u32>,
    /// First moments.
    pub(crate) mean: u32,
    /// Second moments.
    pub(crate) square: u32,
    /// The sum, where there is one.
    pub(crate) sum: u32,
}

impl ParameterGroup {
    /// The parameters of a field, which the model itself holds; all 0.
    pub(crate) fn of_field(layout: &Layout, adam: Adam) -> Self {
        Self {
            parameters: Aligned::new(layout.len()),
            mean: vec![0.0; layout.len() - layout.networks_start()],
            square: Aligned::new(layout.len()),
            sum: Vec::new(),
            adam,
            sections: GroupSections {
                parameters: None,
                mean: kind::MEAN,
                square: kind::SQUARE,
                sum: kind::SUM,
            },
        }
    }

    /// So many parameters of the photographs, which a checkpoint alone holds; all 0.
    pub(crate) fn of_views(n: usize, adam: Adam, sections: GroupSections) -> Self {
        let (parameters, square) = (Aligned::new(n), Aligned::new(n));
        Self { parameters, mean: vec![0.0; n], square, sum: Vec::new(), adam, sections }
    }

    /// All 0 again.
    pub(crate) fn reset(&mut self) {
        for values in [&mut self.parameters[..], &mut self.mean, &mut self.square] {
            values.fill(0.0);
        }
        self.sum = Vec::new();
    }
}

/// All that is learnt.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// The groups; the first is the field's.
    pub(crate) groups: Vec<ParameterGroup>,
    /// Steps whose parameters are in the groups' sums.
    pub(crate) averaged: u32,
    /// How the field's tables are rounded, a byte each; empty: as finely as holds them.
    pub(crate) scales: Vec<u8>,
}

impl State {
    /// Before the first step.
    pub(crate) fn new(field: ParameterGroup) -> Self {
        Self { groups: vec![field], averaged: 0, scales: Vec::new() }
    }

    /// With a group that is learnt beside the field.
    pub(crate) fn with(mut self, group: Option<ParameterGroup>) -> Self {
        self.groups.extend(group);
        self
    }

    /// The field's.
    pub(crate) fn field(&self) -> &ParameterGroup {
        &self.groups[0]
    }

    /// The field's.
    pub(crate) fn field_mut(&mut self) -> &mut ParameterGroup {
        &mut self.groups[0]
    }

    /// The group whose parameters this section of a checkpoint holds, where they are learnt.
    pub(crate) fn group(&self, kind: u32) -> Option<&ParameterGroup> {
        self.groups.iter().find(|group| group.sections.parameters == Some(kind))
    }

    /// The same.
    pub(crate) fn group_mut(&mut self, kind: u32) -> Option<&mut ParameterGroup> {
        self.groups.iter_mut().find(|group| group.sections.parameters == Some(kind))
    }

    /// Whether all parameters are finite; with or without the tables.
    pub(crate) fn is_finite(&self, tables: bool) -> bool {
        self.groups.iter().all(|group| {
            // Tables have no first moment.
            let start = group.parameters.len() - group.mean.len();
            all_finite(&group.parameters[if tables { 0 } else { start }..])
        })
    }

    /// Adds the parameters to their sums.
    pub(crate) fn accumulate(&mut self) {
        /// Values of a task.
        const TASK: usize = 1 << 16;
        for group in &mut self.groups {
            group.sum.resize(group.parameters.len(), 0.0);
            let sums = group.sum.par_chunks_mut(TASK).zip(group.parameters.par_chunks(TASK));
            sums.for_each(|(sums, parameters)| {
                for (sum, parameter) in sums.iter_mut().zip(parameters) {
                    *sum += parameter;
                }
            });
        }
        self.averaged += 1;
    }

    /// With the means of the sums in place of the parameters.
    pub(crate) fn averaged(&self) -> Self {
        let mut state = Self { averaged: 0, scales: Vec::new(), ..self.clone() };
        let inverse = 1.0 / self.averaged as f32;
        for group in &mut state.groups {
            let sums = std::mem::take(&mut group.sum);
            for (parameter, sum) in group.parameters.iter_mut().zip(sums) {
                *parameter = sum * inverse;
            }
        }
        state
    }
}

/// Whether all values are finite.
fn all_finite(values: &[f32]) -> bool {
    // Without an early end inside a piece, so that pieces are checked in lanes.
    let piece = |piece: &[f32]| piece.iter().fold(true, |all, value| all & value.is_finite());
    values.par_chunks(1 << 14).all(piece)
}

#[cfg(test)]
mod tests {
    use super::all_finite;
    use pocketnerf_core::SimdLevel;

    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::{StepSettings, TrainConfig, Trainer};

    #[test]
    fn one_bad_value_is_found_anywhere() {
        let mut values = vec![1.0; 40_000];
        assert!(all_finite(&values));
        for (at, bad) in [(0, f32::NAN), (20_001, f32::INFINITY), (39_999, f32::NEG_INFINITY)] {
            let before = std::mem::replace(&mut values[at], bad);
            assert!(!all_finite(&values));
            values[at] = before;
        }
    }

    fn parameters(trainer: &Trainer) -> &[f32] {
        &trainer.backend.download().field().parameters
    }

    #[test]
    fn a_run_ends_with_the_mean_of_the_steps_that_count() {
        let mut config = TrainConfig::hash_grid();
        let grid = &mut config.field.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        config.samples_per_step = 2048;
        let dataset = builtin::dataset(Split::Train, 16);
        let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
        let settings = |average| StepSettings { average, ..StepSettings::PLAIN };
        // Nothing to average: nothing changes.
        trainer.step(&settings(false));
        let before = parameters(&trainer).to_vec();
        trainer.finish();
        assert_eq!(*parameters(&trainer), *before);
        let mut sum = vec![0.0f64; before.len()];
        for average in [true, false, true, true] {
            trainer.step(&settings(average));
            if average {
                for (sum, value) in sum.iter_mut().zip(parameters(&trainer)) {
                    *sum += f64::from(*value);
                }
            }
        }
        let last = parameters(&trainer).to_vec();
        trainer.finish();
        assert_ne!(*parameters(&trainer), *last);
        for (value, sum) in parameters(&trainer).iter().zip(sum) {
            let mean = sum / 3.0;
            assert!((f64::from(*value) - mean).abs() <= 1e-6 * mean.abs() + 1e-9, "{value} {mean}");
        }
    }
}
