//! Samples to a pixel: the volume rendering sum (Mildenhall et al. 2020,
//! equation 3).

use fearless_simd::{Simd, SimdBase};

use crate::lanes;

/// Turns densities into opacities in place: `alpha = 1 - exp(-sigma step)`.
///
/// `sigma` is a multiple of 16 values, 1 / scene unit; `step` in scene units.
pub fn opacities<S: Simd>(simd: S, sigma: &mut [f32], step: f32) {
    simd.vectorize(
        #[inline(always)]
        || {
            for lanes in sigma.chunks_exact_mut(S::f32s::LEN) {
                let optical = S::f32s::from_slice(simd, lanes) * -step;
                (S::f32s::splat(simd, 1.0) - lanes::exp(simd, optical)).store_slice(lanes);
            }
        },
    );
}

/// What a ray has accumulated so far, beside its channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulated {
    /// Light that still passes: the product of `1 - alpha`.
    pub transmittance: f32,
    /// Sum of weights.
    pub opacity: f32,
    /// Sum of weight times distance.
    pub depth: f32,
}

impl Accumulated {
    /// Nothing accumulated: all light passes.
    pub const EMPTY: Self = Self { transmittance: 1.0, opacity: 0.0, depth: 0.0 };

    /// Adds the sample at distance `t`, and gives its weight.
    #[inline(always)]
    pub fn add(&mut self, alpha: f32, t: f32) -> f32 {
        let weight = self.transmittance * alpha;
        self.transmittance *= 1.0 - alpha;
        self.opacity += weight;
        self.depth += weight * t;
        weight
    }

    /// Part of the light behind that is held back. A ray that has ended because
    /// less than `min_transmittance` passes counts as opaque.
    #[inline(always)]
    #[must_use]
    pub fn alpha(&self, min_transmittance: f32) -> f32 {
        if self.transmittance < min_transmittance { 1.0 } else { self.opacity }
    }

    /// Expected distance, scene units; infinite where nothing was met.
    #[must_use]
    pub fn expected_depth(&self) -> f32 {
        if self.opacity > 0.0 { self.depth / self.opacity } else { f32::INFINITY }
    }
}

/// Samples that rays will still need, at most `most` and at least 1: as many as
/// would make them opaque if all were like the last. `transmittance` is what
/// passes each ray so far, `last_transmittance` the part that passes its last sample.
#[inline(always)]
#[must_use]
pub fn samples_needed<const N: usize>(
    transmittance: &[f32; N],
    last_transmittance: &[f32; N],
    min_transmittance: f32,
    most: usize,
) -> [f32; N] {
    let (mut left, mut needed) = (*transmittance, [1.0; N]);
    for _ in 1..most {
        for ((left, last_transmittance), needed) in
            left.iter_mut().zip(last_transmittance).zip(&mut needed)
        {
            *left *= last_transmittance;
            *needed += if *left < min_transmittance { 0.0 } else { 1.0 };
        }
    }
    needed
}

/// Steps that a sample stands for where `transmittance` is what passes: two below
/// `late`, four below a quarter of it.
#[inline(always)]
#[must_use]
pub fn steps(transmittance: f32, late: f32) -> f32 {
    let later = if transmittance >= late * 0.25 { 2.0 } else { 4.0 };
    if transmittance >= late { 1.0 } else { later }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_needed_by_hand() {
        // Half of what is left passes each sample: 0.1, 0.05, 0.025, 0.0125.
        assert_eq!(samples_needed(&[0.1; 2], &[0.5, 1.0], 0.02, 4), [3.0, 4.0]);
        assert_eq!(samples_needed(&[0.1, 1.0], &[0.0, 0.01], 0.02, 4), [1.0, 1.0]);
        assert_eq!(samples_needed(&[1.0], &[f32::NAN], 0.02, 3), [3.0]);
    }

    #[test]
    fn steps_by_hand() {
        let found = [1.0, 0.3, 0.29, 0.075, 0.07, 0.0].map(|passes| steps(passes, 0.3));
        assert_eq!(found, [1.0, 1.0, 2.0, 2.0, 4.0, 4.0]);
        assert_eq!(steps(0.0, 0.0), 1.0);
    }

    #[test]
    fn five_samples_by_hand() {
        // alpha 0, 1/2, 1/4, 0, 1 at t = 1..5: transmittance before each is
        // 1, 1, 1/2, 3/8, 3/8; weights 0, 1/2, 1/8, 0, 3/8.
        let mut ray = Accumulated::EMPTY;
        let weights = [0.0, 0.5, 0.25, 0.0, 1.0].map({
            let mut t = 0.0;
            move |alpha| {
                t += 1.0;
                (alpha, t)
            }
        });
        let weights = weights.map(|(alpha, t)| ray.add(alpha, t));
        assert_eq!(weights, [0.0, 0.5, 0.125, 0.0, 0.375]);
        assert_eq!(ray.transmittance, 0.0);
        assert_eq!(ray.opacity, 1.0);
        assert_eq!(ray.expected_depth(), 1.0 + 0.375 + 1.875);
        assert_eq!(Accumulated::EMPTY.expected_depth(), f32::INFINITY);
        let nearly = Accumulated { transmittance: 0.01, opacity: 0.99, depth: 3.0 };
        assert_eq!((nearly.alpha(0.01), nearly.alpha(0.02)), (0.99, 1.0));
    }
}
