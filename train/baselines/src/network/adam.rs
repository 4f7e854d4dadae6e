//! Adam (Kingma & Ba 2015).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters that a thread works on at a time.
const PART: usize = 1 << 14;

/// Its constants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Adam {
    pub(crate) beta1: f32,
    pub(crate) beta2: f32,
    pub(crate) epsilon: f32,
}

impl Default for Adam {
    /// As published.
    fn default() -> Self {
        Self { beta1: 0.9, beta2: 0.999, epsilon: 1e-8 }
    }
}

/// Moments of a vector of parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Moments {
    step: u32,
    mean: Vec<f32>,
    square: Vec<f32>,
}

impl Moments {
    pub(crate) fn new(n: usize) -> Self {
        Self { step: 0, mean: vec![0.0; n], square: vec![0.0; n] }
    }

    /// Number of parameters.
    pub(crate) fn len(&self) -> usize {
        self.mean.len().min(self.square.len())
    }

    /// Moves the parameters against their gradient.
    pub(crate) fn step(&mut self, adam: Adam, rate: f32, parameters: &mut [f32], gradient: &[f32]) {
        self.step = self.step.saturating_add(1);
        let correct = |beta: f32| 1.0 - f64::from(beta).powi(self.step.min(1 << 20) as i32);
        let rate = rate * (correct(adam.beta2).sqrt() / correct(adam.beta1)) as f32;
        let moments = self.mean.par_chunks_mut(PART).zip(self.square.par_chunks_mut(PART));
        let parts = parameters.par_chunks_mut(PART).zip(gradient.par_chunks(PART)).zip(moments);
        parts.for_each(|((parameters, gradient), (mean, square))| {
            let moments = mean.iter_mut().zip(square);
            for ((own, g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
                *m += (g - *m) * (1.0 - adam.beta1);
                *v += (g * g - *v) * (1.0 - adam.beta2);
                *own -= rate * *m / (v.sqrt() + adam.epsilon);
            }
        });
    }
}
