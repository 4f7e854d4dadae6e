//! Gradients against finite differences.

use std::ops::Range;

use pocketnerf_train::random::{Random, normal};

/// Compares a gradient with central differences of `loss`, tensor by tensor, along three random
/// directions each.
///
/// # Panics
/// Where they differ by 1e-4, relatively, and where a tensor's gradient is 0.
pub(crate) fn check(
    parameters: &[f64],
    tensors: impl Iterator<Item = Range<usize>>,
    gradient: &[f64],
    loss: impl Fn(&[f64]) -> f64,
) {
    for (i, tensor) in (0..).zip(tensors) {
        for k in 0..3 {
            let mut random = Random::new(5, [1, i, k]);
            let direction: Vec<f64> =
                tensor.clone().map(|_| f64::from(normal(&mut random))).collect();
            let step = 1e-6;
            let at = |sign: f64| {
                let mut moved = parameters.to_vec();
                let moves = moved[tensor.clone()].iter_mut().zip(&direction);
                moves.for_each(|(p, d)| *p += sign * step * d);
                loss(&moved)
            };
            let expected = (at(1.0) - at(-1.0)) / (2.0 * step);
            let found: f64 =
                gradient[tensor.clone()].iter().zip(&direction).map(|(g, d)| g * d).sum();
            assert!(expected != 0.0, "tensor {i}: nothing depends on it");
            let off = (found - expected).abs() / expected.abs().max(1e-6);
            assert!(off < 1e-4, "tensor {i}, direction {k}: {found}, expected {expected}");
        }
    }
}
