extern crate std;
use std::vec;

use fearless_simd::dispatch;

use super::*;
use crate::{DType, Layout, SimdLevel};

/// One input, one output: `y = x`, then ReLU.
fn relu<S: Simd>(simd: S, x: f32) -> f32 {
    let one = 1f32.to_le_bytes();
    let weight = TensorView::new(&one, DType::F32, [1, 1], 0, Layout::RowMajor).unwrap();
    let (input, mut output) = (vec![x; 32], vec![0.0; 32]);
    let mut panel = vec![0.0; panel_len(1)];
    let layer = Dense { weight, bias: None };
    dense(simd, &layer, &input, &mut output, 32, 32, true, &mut panel);
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

/// Sixty-seven points, some outputs that fill no panel, inputs from two places.
#[test]
fn blocks_as_batches() {
    fn check<S: Simd>(simd: S) {
        use blocks::{BLOCK, Blocks, Row, dense_blocks};
        let points = 67usize;
        let (padded, n_blocks) = (points.next_multiple_of(BLOCK), points.div_ceil(BLOCK));
        for ([n_first, n_second], n_out) in
            [([1, 0], 1), ([5, 3], 7), ([16, 9], 8), ([3, 32], 21), ([63, 256], 40)]
        {
            let n_in = n_first + n_second;
            let value = |i: usize| ((i * 7919 + 13) % 1009) as f32 / 504.0 - 1.0;
            let bytes: vec::Vec<u8> =
                (0..n_in * n_out + n_out).flat_map(|i| value(i).to_le_bytes()).collect();
            let tensor = |from: usize, rows: usize| {
                let bytes = &bytes[4 * from..][..4 * rows * n_out];
                let shape = [rows as u32, n_out as u32];
                TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor).unwrap()
            };
            let layer = Dense { weight: tensor(0, n_in), bias: Some(tensor(n_in * n_out, 1)) };
            let x: vec::Vec<f32> = (0..n_in * padded).map(|i| value(3 * i + 1)).collect();
            let mut panel = vec![0.0; panel_len(n_in)];
            let rows = |from: usize, n: usize| {
                let mut rows: vec::Vec<Row> = vec![[0.0; BLOCK]; n_blocks * n];
                for (b, i) in (0..n_blocks).flat_map(|b| (0..n).map(move |i| (b, i))) {
                    rows[b * n + i].copy_from_slice(&x[(from + i) * padded + b * BLOCK..][..BLOCK]);
                }
                rows
            };
            let (first, second) = (rows(0, n_first), rows(n_first, n_second));
            for relu in [false, true] {
                let mut expected = vec![0.0; n_out * padded];
                dense(simd, &layer, &x, &mut expected, padded, padded, relu, &mut panel);
                let mut found = vec![[f32::NAN; BLOCK]; n_blocks * n_out];
                let sources = [
                    Blocks { rows: &first, per_block: n_first },
                    Blocks { rows: &second, per_block: n_second },
                ];
                dense_blocks(simd, &layer, sources, &mut found, relu, &mut panel);
                for (o, p) in (0..n_out).flat_map(|o| (0..padded).map(move |p| (o, p))) {
                    let found = found[p / BLOCK * n_out + o][p % BLOCK];
                    let expected = expected[o * padded + p];
                    assert!((found - expected).abs() < 1e-5 * n_in as f32, "{o} {p}");
                }
            }
        }
    }
    for level in SimdLevel::ALL.into_iter().filter_map(|level| level.token().ok()) {
        dispatch!(level, simd => check(simd));
    }
}
