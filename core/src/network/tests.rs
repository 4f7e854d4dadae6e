extern crate std;
use std::vec;

use fearless_simd::dispatch;

use super::*;
use crate::store::F32;
use crate::{DType, Layout, SimdLevel};

/// One input, one output: `y = x`, then ReLU.
fn relu<S: Simd>(simd: S, x: f32) -> f32 {
    let one = 1f32.to_le_bytes();
    let weight = TensorView::new(&one, DType::F32, [1, 1], 0, Layout::RowMajor).unwrap();
    let (input, mut output) = (vec![x; 32], vec![0.0; 32]);
    let mut panel = vec![0.0; panel_len(1)];
    let layer = Dense { weight, bias: None };
    dense::<S, F32>(simd, &layer, &input, &mut output, 32, 32, true, &mut panel);
    assert!(output.iter().all(|y| y.to_bits() == output[0].to_bits()));
    output[0]
}

#[test]
fn relu_lets_nan_pass_at_every_level() {
    fn check<S: Simd>(simd: S) {
        for nan in [f32::NAN, -f32::NAN] {
            assert!(relu(simd, nan).is_nan());
        }
        for (x, y) in [
            (2.5, 2.5),
            (-2.5, 0.0),
            (0.0, 0.0),
            (f32::INFINITY, f32::INFINITY),
            (f32::NEG_INFINITY, 0.0),
        ] {
            assert_eq!(relu(simd, x), y);
        }
    }
    for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
        dispatch!(level, simd => check(simd));
    }
}
