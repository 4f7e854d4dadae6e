//! Densities to opacities, and samples to a ray's sums.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use fearless_simd::dispatch;
use pocketnerf_core::march::composite::{self, Accumulated, Lengths};

use crate::synthetic::{POINTS, level, numbers};

#[divan::bench]
fn opacities(bencher: Bencher<'_, '_>) {
    let densities = numbers(0, POINTS, 0.0, 300.0);
    let mut values = densities.clone();
    let level = level();
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        values.copy_from_slice(&densities);
        dispatch!(level, simd => composite::opacities(simd, &mut values, Lengths::Equal(0.005)));
        black_box(&mut values);
    });
}

/// Rays of eight samples.
#[divan::bench]
fn sums(bencher: Bencher<'_, '_>) {
    let opacities = numbers(1, POINTS, 0.0, 0.5);
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        let mut depth = 0.0;
        for ray in black_box(&opacities).chunks_exact(8) {
            let mut accumulated = Accumulated::EMPTY;
            for (t, alpha) in (1u16..).zip(ray) {
                accumulated.add(*alpha, f32::from(t));
            }
            depth += accumulated.expected_depth();
        }
        depth
    });
}
