//! Adam (Kingma & Ba 2015), which leaves alone what received no gradient: of a
//! large table, a step touches few entries.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use crate::field::rounding::Rounding;

/// Neighbours that are left alone only together: four entries of a table, whatever the width
/// of the machine's registers, so that it changes nothing but rounding. Decay of entries beside
/// one that is touched is worth 0.17 dB: see docs/lab/training.md.
const BLOCK: usize = 16;

/// First and second moments of networks below these are 0: on their way to it they would become
/// subnormal, for which a processor takes a hundred times as long.
const LEAST: [f32; 2] = [1e-30, 1e-36];

/// A first moment that is no subnormal number. NaN stays.
#[inline(always)]
pub(crate) fn normal(mean: f32) -> f32 {
    if mean.abs() < LEAST[0] { 0.0 } else { mean }
}

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

    /// One step of a few parameters, without decay; `rate` comes from [`Adam::corrected`].
    pub(crate) fn follow(
        &self,
        rate: f32,
        gradient: &[f32],
        [parameters, mean, square]: [&mut [f32]; 3],
    ) {
        let moments = mean.iter_mut().zip(square);
        for ((own, (mean, square)), g) in parameters.iter_mut().zip(moments).zip(gradient) {
            *mean += (g - *mean) * (1.0 - self.beta1);
            *square += (g * g - *square) * (1.0 - self.beta2);
            *own -= rate * *mean / (square.sqrt() + self.epsilon);
        }
    }

    /// One step of every parameter whose block of neighbours received a gradient; `rate` comes from [`Adam::corrected`]. Gives the largest magnitude
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
        let whole = parameters.len() / BLOCK * BLOCK;
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
        let rest = if is_zero(&gradient[whole..]) { whole } else { parameters.len() };
        for i in whole..rest {
            let g = std::mem::take(&mut gradient[i]);
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
        let blocks = parameters
            .chunks_exact_mut(BLOCK)
            .zip(gradient.chunks_exact_mut(BLOCK))
            .zip(square.chunks_exact_mut(BLOCK))
            .zip(rounded.chunks_exact_mut(BLOCK));
        let mut largest = splat(0.0);
        for (block, (((p, g), v), r)) in blocks.enumerate() {
            if is_zero(g) {
                continue;
            }
            let rows = p.chunks_exact_mut(n).zip(g.chunks_exact_mut(n));
            let rows = rows.zip(v.chunks_exact_mut(n)).zip(r.chunks_exact_mut(n));
            for (row, (((p, g), v), r)) in rows.enumerate() {
                let gradient = S::f32s::from_slice(simd, g);
                let mut direction = gradient;
                if MEAN {
                    let m = &mut mean[block * BLOCK + row * n..][..n];
                    let mean = S::f32s::from_slice(simd, m);
                    direction = (gradient - mean).mul_add(splat(1.0 - self.beta1), mean);
                    let faded = direction.abs().simd_lt(splat(LEAST[0]));
                    direction = faded.select(splat(0.0), direction);
                    direction.store_slice(m);
                }
                let square = S::f32s::from_slice(simd, v);
                let square =
                    (gradient * gradient - square).mul_add(splat(1.0 - self.beta2), square);
                let faded = square.simd_lt(splat(LEAST[1]));
                let square = if MEAN { faded.select(splat(0.0), square) } else { square };
                let change = direction / (square.sqrt() + self.epsilon);
                let parameter = S::f32s::from_slice(simd, p);
                let parameter = change.mul_add(splat(-rate), parameter * (1.0 - rate * self.decay));
                parameter.store_slice(p);
                largest = largest.max(parameter.abs());
                rounding.round(simd, parameter, r);
                square.store_slice(v);
                splat(0.0).store_slice(g);
            }
        }
        largest.reduce_max()
    }
}

/// Whether there is no gradient.
#[inline(always)]
fn is_zero(gradient: &[f32]) -> bool {
    // Without an early end, so that it is checked in lanes; -0 is 0 too.
    gradient.iter().fold(0, |bits, value| bits | value.to_bits() << 1) == 0
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
        // 27/32 (1 - sqrt(7)/64) - sqrt(7)/32. Beside those there is only decay.
        let adam = Adam { beta1: 0.0, beta2: 0.75, epsilon: 1e-15, decay: 0.5 };
        let root = 7.0f32.sqrt();
        let kept = [1.0 - 1.0 / 32.0, 1.0 - root / 64.0];
        let expected = [27.0 / 32.0, 27.0 / 32.0 * kept[1] - root / 32.0];
        let beside = [kept[0], kept[0] * kept[1]];
        for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
            // Two blocks and a rest; the second block has no gradient, the others a few.
            let mut p = [1.0f32; 37];
            let (mut g, mut v, mut rounded) = ([0.0; 37], [0.0; 37], [0; 37]);
            let touched = |i: usize| i == 3 || i == 9 || i == 34;
            for (step, gradient) in [2.0, 1.0].into_iter().enumerate() {
                (0..37).filter(|i| touched(*i)).for_each(|i| g[i] = gradient);
                let rate = adam.corrected(0.125, step as u32 + 1);
                dispatch!(level, simd => adam.update(simd, rate, Half, Slices {
                    parameters: &mut p,
                    gradient: &mut g,
                    mean: &mut [],
                    square: &mut v,
                    rounded: &mut rounded,
                }));
                for i in (0..16).chain(32..37) {
                    let expected = if touched(i) { expected[step] } else { beside[step] };
                    assert!((p[i] - expected).abs() < 1e-6, "{i}: {} {expected}", p[i]);
                    let same = if touched(i) { rounded[3] } else { rounded[0] };
                    assert_eq!(rounded[i], same);
                }
                assert!((16..32).all(|i| (p[i], v[i]) == (1.0, 0.0)) && g == [0.0; 37]);
            }
        }
    }
}
