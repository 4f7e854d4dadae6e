//! How bright each photograph is, learnt with the field where photographs are evened out.
//!
//! The gains that are found before training are those beside a small field that has no view
//! dependence: a good beginning, but what neighbouring photographs have in common they take for
//! light of the scene. So the logarithm of a factor for each channel of each photograph is
//! learnt, by which the scene is brighter in it than the gain says.

use super::Adam;
use super::parameters::{GroupSections, ParameterGroup};
use super::run::checkpoint::kind;

/// Channels of a photograph.
pub(crate) const PER_VIEW: usize = 3;
/// Learning rate at its highest ...
const RATE: f32 = 3e-3;
/// ... and what remains of it at the end: what neighbouring photographs have in common is found
/// slowly, because the field shows it as light of the scene.
const FINAL_RATE: f32 = 0.3;
/// Share of the run over which it rises.
const WARM_UP: f32 = 0.02;
/// The constants of Adam.
const ADAM: Adam = Adam { beta1: 0.9, beta2: 0.99, epsilon: 1e-15, decay: 0.0 };

/// How gains are learnt in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GainStep<'s> {
    /// Those that photographs are evened out by.
    pub(crate) given: &'s [[f32; 3]],
    rate: f32,
}

/// The parameters of so many photographs.
pub(crate) fn group(views: usize) -> ParameterGroup {
    let sections = GroupSections {
        parameters: Some(kind::GAINS),
        mean: kind::GAIN_MEAN,
        square: kind::GAIN_SQUARE,
        sum: kind::GAIN_SUM,
    };
    ParameterGroup::of_views(PER_VIEW * views, ADAM, sections)
}

/// The factors of these parameters.
pub(crate) fn factors(parameters: &[f32]) -> Vec<[f32; 3]> {
    parameters.as_chunks().0.iter().map(|own: &[f32; 3]| own.map(f32::exp)).collect()
}

impl<'s> GainStep<'s> {
    /// The step of a run after this share of it; `None` where photographs are taken as they are.
    pub(crate) fn new(given: &'s [[f32; 3]], progress: f32) -> Option<Self> {
        let rate = RATE * (progress / WARM_UP).min(1.0) * FINAL_RATE.powf(progress);
        (!given.is_empty()).then_some(Self { given, rate })
    }

    /// New parameters, from their gradient. `number` counts steps from 1.
    pub(crate) fn update(&self, group: &mut ParameterGroup, gradient: &[[f32; 3]], number: u32) {
        let rate = group.adam.corrected(self.rate, number);
        let ParameterGroup { parameters, mean, square, adam, .. } = group;
        adam.follow(rate, gradient.as_flattened(), [&mut parameters[..], mean, square]);
        self.fix(parameters);
    }

    /// On the whole, photographs stay as bright as they were taken: how bright the scene is beyond
    /// that, none of them tells.
    fn fix(&self, parameters: &mut [f32]) {
        let n = self.given.len() as f64;
        for c in 0..PER_VIEW {
            let given = self.given.iter().map(|gains| f64::from(gains[c]).ln());
            let learnt = parameters.iter().skip(c).step_by(PER_VIEW).map(|own| f64::from(*own));
            let middle = (learnt.sum::<f64>() - given.sum::<f64>()) / n;
            for own in parameters.iter_mut().skip(c).step_by(PER_VIEW) {
                *own -= middle as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photographs_stay_as_bright_on_the_whole() {
        let given = [[2.0, 1.0, 1.0], [0.5, 1.0, 4.0]];
        let step = GainStep::new(&given, 0.5).unwrap();
        let mut group = group(2);
        group.parameters.copy_from_slice(&[0.1, 0.2, 0.3, 0.3, -0.2, 0.5]);
        step.update(&mut group, &[[0.0; 3]; 2], 1);
        // Total gains are 2 e^-x and so on: logarithms of each channel have the mean 0.
        let half = 0.5 * 4f32.ln();
        let expected = [-0.1, 0.2, half - 0.1, 0.1, -0.2, half + 0.1];
        for (own, expected) in group.parameters.iter().zip(expected) {
            assert!((own - expected).abs() < 1e-6, "{:?}", &group.parameters[..]);
        }
        // A gradient is followed downhill, whatever its size, by the rate.
        step.update(&mut group, &[[1e-3, 0.0, 0.0], [-1e-3, 0.0, 0.0]], 2);
        assert!(group.parameters[0] < -0.1 && group.parameters[3] > 0.1);
        assert!(GainStep::new(&[], 0.5).is_none());
    }
}
