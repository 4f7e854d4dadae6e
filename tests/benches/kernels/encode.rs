//! Points to the features of a hash grid of 9 levels with up to 2^16 entries.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use fearless_simd::dispatch;
use pocketnerf_core::encoding::hash_grid::encode;
use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
use pocketnerf_core::store::{F16, F32, I8};
use pocketnerf_core::{Layout, TensorView};

use crate::synthetic::{POINTS, Stored, level, numbers, stored};

#[divan::bench(types = [I8, F16, F32], consts = [2, 4])]
fn random_points<T: Stored, const FEATURES: u32>(bencher: Bencher<'_, '_>) {
    let config = HashGridConfig {
        n_levels: 9,
        n_features_per_level: FEATURES,
        log2_hashmap_size: 16,
        base_resolution: 16,
        per_level_scale: 1.65,
        index: GridIndex::Blocked,
    };
    let tables: Vec<Vec<u8>> = (0..9)
        .map(|l| {
            let n = config.level(l).entries * FEATURES;
            stored(T::DTYPE, &numbers(l as u64, n as usize, -1.0, 1.0))
        })
        .collect();
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    for (l, (view, table)) in levels.iter_mut().zip(&tables).enumerate() {
        let shape = [config.level(l).entries, FEATURES];
        *view = TensorView::new(table, T::DTYPE, shape, 0, Layout::RowMajor).expect("fits");
    }
    let grid = HashGrid { config, levels };
    // Many batches, so that the caches hold of the tables what they hold in a picture.
    let points = [20, 21, 22].map(|axis| numbers(axis, 16 * POINTS, 0.0, 1.0));
    let mut out = vec![0.0; config.n_output() * POINTS];
    let mut batch = 0;
    let level = level();
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        batch = (batch + 1) % 16;
        let points = points.each_ref().map(|axis| &axis[batch * POINTS..][..POINTS]);
        dispatch!(level, simd => encode(simd, &grid, points, &mut out, POINTS));
        black_box(&mut out);
    });
}
