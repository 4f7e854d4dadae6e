//! Adam (Kingma & Ba 2015), which leaves alone what received no gradient: of a
//! large table, a step touches few entries.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::field::rounding::Rounding;

/// Adam's constants. `beta1` 0 is Adam without momentum: no first moment is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adam {
    /// Decay of the mean gradient.
    pub beta1: f32,
    /// Decay of the mean squared gradient.
    pub beta2: f32,
    /// Keeps the division finite.
    pub epsilon: f32,
    /// Part of a parameter that a step takes away, times the learning rate, where
    /// there is a gradient (AdamW, Loshchilov & Hutter 2019).
    pub decay: f32,
}

impl Default for Adam {
    /// Gradients of grid entries are tiny, and so is epsilon (instant-ngp's). The
    /// second moment forgets faster than usual: runs are short.
    fn default() -> Self {
        Self { beta1: 0.9, beta2: 0.95, epsilon: 1e-15, decay: 0.0 }
    }
}

/// Parameters with their gradient and both moments: slices of equal length.
#[derive(Debug)]
pub struct Slices<'p, B> {
    /// Changed.
    pub parameters: &'p mut [f32],
    /// Read, and zeroed for the next step.
    pub gradient: &'p mut [f32],
    /// First moment; empty: steps follow the gradient itself.
    pub mean: &'p mut [f32],
    /// Second moment.
    pub square: &'p mut [f32],
    /// The parameters once more, rounded.
    pub rounded: &'p mut [B],
}

impl<B> Slices<'_, B> {
    /// The first `n` parameters, which are no longer among these.
    pub(crate) fn split_off(&mut self, n: usize) -> Self {
        Self {
            parameters: self.parameters.split_off_mut(..n).unwrap_or_default(),
            gradient: self.gradient.split_off_mut(..n).unwrap_or_default(),
            mean: self.mean.split_off_mut(..n).unwrap_or_default(),
            square: self.square.split_off_mut(..n).unwrap_or_default(),
            rounded: self.rounded.split_off_mut(..n).unwrap_or_default(),
        }
    }
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

    /// One step of every parameter that received a gradient; `rate` comes from [`Adam::corrected`]. Gives the largest magnitude
    /// that any of them has now.
    #[inline(always)]
    pub fn update<S: Simd, R: Rounding>(
        &self,
        simd: S,
        rate: f32,
        rounding: R,
        slices: Slices<'_, R::Bits>,
    ) -> f32 {
        let Slices { parameters, gradient, mean, square, rounded } = slices;
        let whole = parameters.len() / S::f32s::LEN * S::f32s::LEN;
        let kept = 1.0 - rate * self.decay;
        let mut largest = if mean.is_empty() {
            self.whole_registers::<S, R, false>(
                simd, rate, rounding, parameters, gradient, mean, square, rounded,
            )
        } else {
            self.whole_registers::<S, R, true>(
                simd, rate, rounding, parameters, gradient, mean, square, rounded,
            )
        };
        for i in whole..parameters.len() {
            let g = std::mem::take(&mut gradient[i]);
            if g == 0.0 {
                continue;
            }
            let mut direction = g;
            if let Some(mean) = mean.get_mut(i) {
                *mean += (g - *mean) * (1.0 - self.beta1);
                direction = *mean;
            }
            square[i] += (g * g - square[i]) * (1.0 - self.beta2);
            let change = direction / (square[i].sqrt() + self.epsilon);
            parameters[i] = kept * parameters[i] - rate * change;
            largest = largest.max(parameters[i].abs());
        }
        rounding.round_all(simd, &parameters[whole..], &mut rounded[whole..]);
        largest
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the parts of `Slices`")]
    fn whole_registers<S: Simd, R: Rounding, const MEAN: bool>(
        &self,
        simd: S,
        rate: f32,
        rounding: R,
        parameters: &mut [f32],
        gradient: &mut [f32],
        mean: &mut [f32],
        square: &mut [f32],
        rounded: &mut [R::Bits],
    ) -> f32 {
        let n = S::f32s::LEN;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let rows = parameters
            .chunks_exact_mut(n)
            .zip(gradient.chunks_exact_mut(n))
            .zip(square.chunks_exact_mut(n))
            .zip(rounded.chunks_exact_mut(n));
        let mut largest = splat(0.0);
        for (i, (((p, g), v), r)) in rows.enumerate() {
            let gradient = S::f32s::from_slice(simd, g);
            let untouched = gradient.simd_eq(splat(0.0));
            if untouched.all_true() {
                continue;
            }
            let mut direction = gradient;
            if MEAN {
                let m = &mut mean[i * n..(i + 1) * n];
                let mean = S::f32s::from_slice(simd, m);
                let new = (gradient - mean).mul_add(splat(1.0 - self.beta1), mean);
                direction = untouched.select(mean, new);
                direction.store_slice(m);
            }
            let before = S::f32s::from_slice(simd, v);
            let new = (gradient * gradient - before).mul_add(splat(1.0 - self.beta2), before);
            let square = untouched.select(before, new);
            let change = direction / (square.sqrt() + self.epsilon);
            let before = S::f32s::from_slice(simd, p);
            let new = change.mul_add(splat(-rate), before * (1.0 - rate * self.decay));
            // Each parameter by itself: registers of other widths give the same.
            let parameter = untouched.select(before, new);
            parameter.store_slice(p);
            largest = largest.max(parameter.abs());
            rounding.round(simd, parameter, r);
            square.store_slice(v);
            splat(0.0).store_slice(g);
        }
        largest.reduce_max()
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::field::rounding::Half;

    #[test]
    fn two_steps_by_hand() {
        // Without momentum, β2 = 3/4, rate 1/8, decay 1/2; gradient 2, then 1.
        // v = 4/4 = 1, then 1 + (1 - 1) / 4 = 1; the correction sqrt(1 - β2^k) makes
        // the rates 1/16 and sqrt(7)/32. p = 1 (1 - 1/32) - 2/16 = 27/32, then
        // 27/32 (1 - sqrt(7)/64) - sqrt(7)/32.
        let adam = Adam { beta1: 0.0, beta2: 0.75, epsilon: 0.0, decay: 0.5 };
        let root = 7.0f32.sqrt();
        let expected = [27.0 / 32.0, 27.0 / 32.0 * (1.0 - root / 64.0) - root / 32.0];
        for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
            // Registers' worth and a rest. Some have no gradient, which is so of every third
            // value of the others too.
            let mut p = [1.0f32; 33];
            let (mut g, mut v, mut rounded) = ([0.0; 33], [0.0; 33], [0; 33]);
            let touched = |i: usize| (i < 16 || i == 32) && i % 3 != 2;
            for (step, (gradient, expected)) in (1..).zip([2.0, 1.0].into_iter().zip(expected)) {
                (0..33).filter(|i| touched(*i)).for_each(|i| g[i] = gradient);
                let rate = adam.corrected(0.125, step);
                dispatch!(level, simd => adam.update(simd, rate, Half, Slices {
                    parameters: &mut p,
                    gradient: &mut g,
                    mean: &mut [],
                    square: &mut v,
                    rounded: &mut rounded,
                }));
                for i in (0..33).filter(|i| touched(*i)) {
                    assert!((p[i] - expected).abs() < 1e-6, "{i}: {} {expected}", p[i]);
                    assert_eq!(rounded[i], rounded[0]);
                }
                let untouched = || (0..33).filter(|i| !touched(*i));
                assert!(untouched().all(|i| (p[i], v[i]) == (1.0, 0.0)) && g == [0.0; 33]);
            }
        }
    }
}
