//! A dense layer, points in the lanes.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use fearless_simd::dispatch;
use pocketnerf_core::network::{Dense, dense, panel_len};
use pocketnerf_core::{DType, Layout, TensorView, Tuning};

use crate::synthetic::{POINTS, level, numbers, stored};

/// Items are floating-point operations.
#[divan::bench(args = [[36, 64], [64, 64], [64, 16], [64, 3]])]
fn layer(bencher: Bencher<'_, '_>, [n_in, n_out]: [usize; 2]) {
    let stride = Tuning::FAST.stride();
    let weights = stored(DType::F16, &numbers(0, n_in * n_out, -0.3, 0.3));
    let biases = stored(DType::F16, &numbers(1, n_out, -0.3, 0.3));
    let tensor = |bytes, rows: usize| {
        let shape = [rows as u32, n_out as u32];
        TensorView::new(bytes, DType::F16, shape, 0, Layout::RowMajor).expect("fits")
    };
    let layer = Dense { weight: tensor(&weights, n_in), bias: Some(tensor(&biases, 1)) };
    let x = numbers(2, n_in * stride, -1.0, 1.0);
    let mut y = vec![0.0; n_out * stride];
    let mut panel = vec![0.0; panel_len(n_in)];
    let level = level();
    bencher.counter(ItemsCount::new(2 * n_in * n_out * POINTS)).bench_local(|| {
        dispatch!(level, simd => {
            dense(simd, &layer, &x, &mut y, POINTS, stride, true, &mut panel);
        });
        black_box(&mut y);
    });
}
