//! Planes and lines that are smooth where photographs do not say otherwise: entries move towards
//! the mean of their neighbours (the gradient of a squared total variation, as Chen et al. 2022 add
//! it to the loss, but apart from Adam, as AdamW's decay is).

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use pocketnerf_core::encoding::planes::FEATURES;

/// Entries of a plane with rows of `side` that have a gradient, but for those at its edges.
#[inline(always)]
pub(super) fn plane<S: Simd>(
    simd: S,
    side: usize,
    share: f32,
    parameters: &mut [f32],
    gradient: &[f32],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let entries = parameters.as_chunks_mut::<FEATURES>().0;
            let gradient = gradient.as_chunks::<FEATURES>().0;
            for y in 1..side - 1 {
                let row = y * side;
                for i in row + 1..row + side - 1 {
                    let none = f32x8::load_array_ref(simd, &gradient[i]).simd_eq(0.0);
                    if none.all_true() {
                        continue;
                    }
                    let entry = |i: usize| f32x8::load_array_ref(simd, &entries[i]);
                    let beside = entry(i - 1) + entry(i + 1);
                    let sum = beside + (entry(i - side) + entry(i + side));
                    let change = sum * 0.25 - entry(i);
                    change
                        .mul_add(f32x8::splat(simd, share), entry(i))
                        .store_array(&mut entries[i]);
                }
            }
        },
    );
}

/// Those of a line, but for its ends.
pub(super) fn line(share: f32, parameters: &mut [f32], gradient: &[f32]) {
    let entries = parameters.as_chunks_mut::<FEATURES>().0;
    let gradient = gradient.as_chunks::<FEATURES>().0;
    for i in 1..entries.len().saturating_sub(1) {
        if gradient[i] == [0.0; FEATURES] {
            continue;
        }
        let [before, own, behind] = [i - 1, i, i + 1].map(|i| entries[i]);
        for (v, value) in entries[i].iter_mut().enumerate() {
            *value += share * (0.5 * (before[v] + behind[v]) - own[v]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn a_spike_spreads_and_slopes_stay() {
        // x + 2 y, a spike of 8 at (2, 1), and no gradient at (1, 2).
        let at =
            |i: usize| ((i % 4) as f32 + 2.0 * (i / 4) as f32, [0.0, 8.0][usize::from(i == 6)]);
        let values = |i: usize| [at(i).0 + at(i).1; FEATURES];
        let mut entries: Vec<f32> = (0..16).flat_map(values).collect();
        let mut gradient = vec![1.0; entries.len()];
        gradient[9 * FEATURES..10 * FEATURES].fill(0.0);
        let level = Level::new();
        dispatch!(level, simd => plane(simd, 4, 0.5, &mut entries, &gradient));
        let spikes: Vec<f32> = (0..16).map(|i| entries[i * FEATURES] - at(i).0).collect();
        let mut expected = [0.0; 16];
        // From left to right: what is left of the spike, and what it gives on.
        expected[5] = 0.5 * 0.25 * 8.0;
        expected[6] = 0.5 * 8.0 + 0.5 * 0.25 * expected[5];
        expected[10] = 0.5 * 0.25 * expected[6];
        assert_eq!(spikes, expected);
    }

    #[test]
    fn ends_of_lines_stay() {
        let mut entries: Vec<f32> =
            [3.0, 0.0, 1.0, 9.0].iter().flat_map(|value| [*value; FEATURES]).collect();
        let gradient = vec![1.0; entries.len()];
        line(0.5, &mut entries, &gradient);
        let found: Vec<f32> = entries.iter().step_by(FEATURES).copied().collect();
        // Half of the way to 2, then half of the way to the mean of 1 and 9.
        assert_eq!(found, [3.0, 1.0, 3.0, 9.0]);
    }
}
