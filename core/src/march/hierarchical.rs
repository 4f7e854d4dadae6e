//! The paper's sampling (Mildenhall et al. 2020, sections 4 and 5.2): evenly spaced
//! samples first, then more of them where the first have weight.
//!
//! The arithmetic is that of the authors' program, so that networks trained with it
//! see the same points.

use fearless_simd::{Simd, SimdBase};

use crate::lanes;

/// Evenly spaced distances, the first at `near`, the last at `far`.
pub fn evenly(near: f32, far: f32, t: &mut [f32]) {
    let last = (t.len().max(2) - 1) as f32;
    for (i, t) in t.iter_mut().enumerate() {
        let along = i as f32 / last;
        *t = near * (1.0 - along) + far * along;
    }
}

/// Moves evenly spaced distances, each to anywhere nearer to it than to its neighbours
/// (stratified sampling, equation 2). `uniform` draws from 0 to 1.
pub fn jitter(t: &mut [f32], mut uniform: impl FnMut() -> f32) {
    let mut lower = t.first().copied().unwrap_or(0.0);
    for i in 0..t.len() {
        let upper = t.get(i + 1).map_or(t[i], |next| 0.5 * (t[i] + next));
        t[i] = lower + (upper - lower) * uniform();
        lower = upper;
    }
}

/// Where the last sample's part of a ray ends if nothing else ends it.
pub const ENDLESS: f32 = 1e10;

/// Turns densities at the distances `t` into opacities, in place: each sample stands for
/// what lies between it and the next, the last for what lies before `end`: where a ray
/// leaves the space, or [`ENDLESS`]. A multiple of 16 densities; those beyond `t.len()`
/// become 0.
pub fn opacities<S: Simd>(simd: S, sigma: &mut [f32], t: &[f32], end: f32) {
    let (samples, rest) = sigma.split_at_mut(t.len());
    rest.fill(0.0);
    for (sigma, pair) in samples.iter_mut().zip(t.windows(2)) {
        *sigma *= pair[1] - pair[0];
    }
    if let (Some(last), Some(t)) = (samples.last_mut(), t.last()) {
        *last *= end - t;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            for lanes in sigma.chunks_exact_mut(S::f32s::LEN) {
                let optical = -S::f32s::from_slice(simd, lanes);
                (S::f32s::splat(simd, 1.0) - lanes::exp(simd, optical)).store_slice(lanes);
            }
        },
    );
}

/// Opacities to weights, in place: what of the light that passes a sample is held back
/// there.
pub fn weights(alpha: &mut [f32]) {
    let mut transmittance = 1.0;
    for alpha in alpha {
        let passed = 1.0 - *alpha;
        *alpha *= transmittance;
        transmittance *= passed;
    }
}

/// Distances where the `weights` of samples at `t` are: the inverse of their cumulative
/// distribution, taken as even between the middles of neighbours. `at` gives what is to
/// be inverted for each of `found`, ascending from 0 to 1; so are the distances.
pub fn inverse_cdf(t: &[f32], weights: &[f32], at: impl Fn(usize) -> f32, found: &mut [f32]) {
    let n = t.len().min(weights.len());
    if n < 3 {
        return;
    }
    let middle = |i: usize| 0.5 * (t[i] + t[i + 1]);
    // The first and the last sample's weight do not count; a little everywhere lets no
    // bin be forgotten. What is no number counts as nothing.
    let weight = |i: usize| weights[i + 1].max(0.0) + 1e-5;
    let total: f32 = (0..n - 2).map(weight).sum();
    let (mut bin, mut before) = (0, 0.0);
    for (i, found) in found.iter_mut().enumerate() {
        let at = at(i);
        let mut part = weight(bin) / total;
        while bin + 3 < n && before + part <= at {
            before += part;
            bin += 1;
            part = weight(bin) / total;
        }
        let inside = ((at - before) / if part < 1e-5 { 1.0 } else { part }).clamp(0.0, 1.0);
        *found = middle(bin) + inside * (middle(bin + 1) - middle(bin));
    }
}

/// Two ascending lists as one.
pub fn merge(first: &[f32], second: &[f32], all: &mut [f32]) {
    let (mut a, mut b) = (first.iter().peekable(), second.iter().peekable());
    for to in all {
        let take_second = match (a.peek(), b.peek()) {
            (Some(a), Some(b)) => b < a,
            (a, _) => a.is_none(),
        };
        *to = if take_second { b.next() } else { a.next() }.copied().unwrap_or(f32::INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_and_jittered_by_hand() {
        let mut t = [0.0; 5];
        evenly(2.0, 6.0, &mut t);
        assert_eq!(t, [2.0, 3.0, 4.0, 5.0, 6.0]);
        let mut moved = t;
        jitter(&mut moved, || 0.0);
        assert_eq!(moved, [2.0, 2.5, 3.5, 4.5, 5.5]);
        jitter(&mut t, || 0.5);
        assert_eq!(t, [2.25, 3.0, 4.0, 5.0, 5.75]);
    }

    #[test]
    fn weights_by_hand() {
        // sigma δ is ln 2 for the first two samples: half of the light each.
        let ln_2 = core::f32::consts::LN_2;
        let mut values = [ln_2, 0.5 * ln_2, 0.0, 1.0, 9.0];
        let level = crate::SimdLevel::compiled().token().unwrap();
        let mut padded = [0.0; 16];
        padded[..5].copy_from_slice(&values);
        fearless_simd::dispatch!(level, simd => {
            opacities(simd, &mut padded, &[1.0, 2.0, 4.0, 5.0], ENDLESS);
        });
        weights(&mut padded[..4]);
        values.copy_from_slice(&padded[..5]);
        for (found, expected) in values.iter().zip([0.5, 0.25, 0.0, 0.25, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{values:?}");
        }
    }

    #[test]
    fn samples_where_the_weights_are() {
        // Middles 0.5, 1.5, 2.5, 3.5: three bins, weights 0, 3 and 1 (the ends' do not
        // count). A quarter into the distribution is a third of the second bin.
        let (t, weights) = ([0.0, 1.0, 2.0, 3.0, 4.0], [7.0, 0.0, 3.0, 1.0, 7.0]);
        let mut found = [0.0; 5];
        inverse_cdf(&t, &weights, |i| i as f32 / 4.0, &mut found);
        let expected = [0.5, 1.5 + 1.0 / 3.0, 1.5 + 2.0 / 3.0, 2.5, 3.5];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 2e-4, "{found} {expected}");
        }
        // Nothing anywhere: evenly.
        inverse_cdf(&t, &[f32::NAN; 5], |i| i as f32 / 4.0, &mut found);
        for (i, found) in found.iter().enumerate() {
            assert!((found - (0.5 + 0.75 * i as f32)).abs() < 1e-3, "{found}");
        }
    }

    #[test]
    fn two_lists_become_one() {
        let mut all = [0.0; 7];
        merge(&[1.0, 4.0, 5.0], &[0.5, 4.0, 4.5, 9.0], &mut all);
        assert_eq!(all, [0.5, 1.0, 4.0, 4.0, 4.5, 5.0, 9.0]);
    }
}
