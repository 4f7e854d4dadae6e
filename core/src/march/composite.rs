//! Samples to a pixel: the volume rendering sum (Mildenhall et al. 2020,
//! equation 3).

use fearless_simd::{Simd, SimdBase};

use crate::lanes;

/// The lengths that a batch's samples stand for, scene units.
#[derive(Clone, Copy, Debug)]
pub enum Lengths<'l> {
    /// The same for all.
    Equal(f32),
    /// Each sample's own, times a factor.
    Each(&'l [f32], f32),
}

/// Turns densities into opacities in place: `alpha = 1 - exp(-sigma length)`.
///
/// `sigma` is a multiple of 16 values, 1 / scene unit.
pub fn opacities<S: Simd>(simd: S, sigma: &mut [f32], lengths: Lengths<'_>) {
    simd.vectorize(
        #[inline(always)]
        || {
            let n = S::f32s::LEN;
            match lengths {
                Lengths::Equal(length) => {
                    let length = S::f32s::splat(simd, length);
                    for sigma in sigma.chunks_exact_mut(n) {
                        opacity(simd, sigma, length);
                    }
                }
                Lengths::Each(lengths, factor) => {
                    for (sigma, own) in sigma.chunks_exact_mut(n).zip(lengths.chunks_exact(n)) {
                        opacity(simd, sigma, S::f32s::from_slice(simd, own) * factor);
                    }
                }
            }
        },
    );
}

/// A register of [`opacities`].
#[inline(always)]
fn opacity<S: Simd>(simd: S, sigma: &mut [f32], length: S::f32s) {
    let optical = S::f32s::from_slice(simd, sigma) * -length;
    (S::f32s::splat(simd, 1.0) - lanes::exp(simd, optical)).store_slice(sigma);
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

    /// Adds the sample at distance `t`, and returns its weight.
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

/// Samples that a ray will still need, at most `most` and at least 1: as many as would
/// make it opaque if all were like the last. `transmittance` is what passes so far,
/// `last_transmittance` the part that its last sample let pass.
#[inline(always)]
#[must_use]
pub fn samples_needed(
    transmittance: f32,
    last_transmittance: f32,
    min_transmittance: f32,
    most: usize,
) -> f32 {
    let (mut left, mut needed) = (transmittance, 1.0);
    for _ in 1..most {
        left *= last_transmittance;
        needed += if left < min_transmittance { 0.0 } else { 1.0 };
    }
    needed
}

/// Steps that a sample stands for where `transmittance` is what passes: two below
/// `coarse_below`, four below a quarter of it.
#[inline(always)]
#[must_use]
pub fn steps(transmittance: f32, coarse_below: f32) -> f32 {
    let later = if transmittance >= coarse_below * 0.25 { 2.0 } else { 4.0 };
    if transmittance >= coarse_below { 1.0 } else { later }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_needed_by_hand() {
        // Half of what is left passes each sample: 0.1, 0.05, 0.025, 0.0125.
        assert_eq!(samples_needed(0.1, 0.5, 0.02, 4), 3.0);
        assert_eq!(samples_needed(0.1, 1.0, 0.02, 4), 4.0);
        assert_eq!(samples_needed(0.1, 0.0, 0.02, 4), 1.0);
        assert_eq!(samples_needed(1.0, 0.01, 0.02, 4), 1.0);
        assert_eq!(samples_needed(1.0, f32::NAN, 0.02, 3), 3.0);
    }

    #[test]
    fn opacities_by_hand() {
        let ln_2 = core::f32::consts::LN_2;
        for level in crate::SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
            let mut equal = [2.0 * ln_2; 16];
            let mut each = equal;
            let mut lengths = [0.5; 16];
            (lengths[0], lengths[1]) = (0.0, 1.0);
            fearless_simd::dispatch!(level, simd => {
                opacities(simd, &mut equal, Lengths::Equal(0.5));
                opacities(simd, &mut each, Lengths::Each(&lengths, 2.0));
            });
            for (found, expected) in
                [(equal[7], 0.5), (each[0], 0.0), (each[1], 0.9375), (each[9], 0.75)]
            {
                assert!((found - expected).abs() < 1e-6, "{level:?}: {found}, by hand {expected}");
            }
        }
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
