//! A step of all parameters: sum the groups' gradients, Muon at first, then Adam.

use std::sync::{Mutex, PoisonError};

use fearless_simd::dispatch;

use crate::field::rounding::Unrounded;
use crate::field::{Layout, Update, sum_groups};
use crate::stopwatch::{Laps, Stage};
use crate::trainer::{Slices, muon};

/// Gradients of each group of rays, and their sum. A group has one thread at a time.
#[derive(Debug)]
pub(in crate::field) struct Gradients {
    pub(in crate::field) groups: Vec<Mutex<Vec<f32>>>,
    pub(in crate::field) sum: Vec<f32>,
}

impl Gradients {
    /// For so many parameters.
    pub(in crate::field) fn new(parameters: usize) -> Self {
        Self { groups: Vec::new(), sum: vec![0.0; parameters] }
    }

    /// Room for so many groups.
    pub(in crate::field) fn prepare(&mut self, groups: usize) {
        let len = self.sum.len();
        self.groups.resize_with(groups, || Mutex::new(vec![0.0; len]));
    }

    /// Changes parameters as the groups say: by Muon at first where `by_muon`.
    pub(in crate::field) fn follow(&mut self, by_muon: bool, layout: &Layout, update: Update<'_>) {
        let Update { level, parameters, mean, square, step, adam, rate, stopwatch, .. } = update;
        let Self { groups, sum } = self;
        let mut laps = Laps::begin(stopwatch);
        let groups: Vec<&[f32]> = groups
            .iter_mut()
            .map(|group| &group.get_mut().unwrap_or_else(PoisonError::into_inner)[..])
            .collect();
        sum_groups(sum, &groups);
        laps.end(Stage::Reduce, 1);
        let rounded = &mut vec![(); parameters.len()][..];
        let slices = Slices { parameters, gradient: sum, mean, square, rounded };
        let corrected = adam.corrected(rate, step);
        if by_muon && step <= muon::STEPS {
            muon::update_all(level, rate, layout, (&adam, corrected), Unrounded, slices);
        } else {
            dispatch!(level, simd => adam.update(simd, corrected, Unrounded, slices));
        }
        laps.end(Stage::Adam, 0);
    }

    /// The sum of the groups, as [`follow`](Self::follow) would see it.
    #[cfg(test)]
    pub(in crate::field) fn summed(&self) -> Vec<f32> {
        let mut sum = vec![0.0; self.sum.len()];
        for group in &self.groups {
            sum.iter_mut().zip(&*group.lock().unwrap()).for_each(|(sum, g)| *sum += g);
        }
        sum
    }
}
