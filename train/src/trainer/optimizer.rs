//! Adam (Kingma & Ba 2015), which leaves alone what received no gradient: of a
//! large table, a step touches few entries.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask};

use crate::field::half::{round, round_all};

/// Adam's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adam {
    /// Decay of the mean gradient.
    pub beta1: f32,
    /// Decay of the mean squared gradient.
    pub beta2: f32,
    /// Keeps the division finite.
    pub epsilon: f32,
}

impl Default for Adam {
    /// instant-ngp's: gradients of grid entries are tiny, and so is epsilon.
    fn default() -> Self {
        Self { beta1: 0.9, beta2: 0.99, epsilon: 1e-15 }
    }
}

/// Parameters with their gradient and both moments: slices of equal length.
#[derive(Debug)]
pub struct Slices<'p> {
    /// Changed.
    pub parameters: &'p mut [f32],
    /// Read, and zeroed for the next step.
    pub gradient: &'p mut [f32],
    /// First moment.
    pub mean: &'p mut [f32],
    /// Second moment.
    pub square: &'p mut [f32],
    /// The parameters once more, rounded to half precision.
    pub half: &'p mut [u16],
}

impl Adam {
    /// The step length that includes the correction of both moments' bias
    /// after `step` steps, counted from 1.
    #[must_use]
    pub fn corrected(&self, learning_rate: f32, step: u32) -> f32 {
        let correct = |beta: f32| 1.0 - f64::from(beta).powi(step.min(1 << 20) as i32);
        let factor = correct(self.beta2).sqrt() / correct(self.beta1);
        (f64::from(learning_rate) * factor) as f32
    }

    /// One step of every parameter whose register of neighbours received a
    /// gradient; `rate` comes from [`Adam::corrected`].
    #[inline(always)]
    pub fn update<S: Simd>(&self, simd: S, rate: f32, slices: Slices<'_>) {
        let n = S::f32s::LEN;
        let whole = slices.parameters.len() / n * n;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let Slices { parameters, gradient, mean, square, half } = slices;
        let rows = parameters[..whole]
            .chunks_exact_mut(n)
            .zip(gradient[..whole].chunks_exact_mut(n))
            .zip(mean[..whole].chunks_exact_mut(n))
            .zip(square[..whole].chunks_exact_mut(n))
            .zip(half[..whole].chunks_exact_mut(n));
        for ((((p, g), m), v), h) in rows {
            let gradient = S::f32s::from_slice(simd, g);
            if gradient.simd_eq(splat(0.0)).all_true() {
                continue;
            }
            let mean = S::f32s::from_slice(simd, m);
            let mean = (gradient - mean).mul_add(splat(1.0 - self.beta1), mean);
            let square = S::f32s::from_slice(simd, v);
            let square = (gradient * gradient - square).mul_add(splat(1.0 - self.beta2), square);
            let change = mean / (square.sqrt() + self.epsilon);
            let parameter = S::f32s::from_slice(simd, p);
            let parameter = change.mul_add(splat(-rate), parameter);
            parameter.store_slice(p);
            round(simd, parameter, h);
            mean.store_slice(m);
            square.store_slice(v);
            splat(0.0).store_slice(g);
        }
        for i in whole..parameters.len() {
            let g = std::mem::take(&mut gradient[i]);
            if g == 0.0 {
                continue;
            }
            mean[i] += (g - mean[i]) * (1.0 - self.beta1);
            square[i] += (g * g - square[i]) * (1.0 - self.beta2);
            parameters[i] -= rate * mean[i] / (square[i].sqrt() + self.epsilon);
        }
        round_all(simd, &parameters[whole..], &mut half[whole..]);
    }
}
