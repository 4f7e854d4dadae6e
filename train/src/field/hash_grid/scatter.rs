//! The grid's gradient: that of encoded points, added to the entries they read.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x4};
use pocketnerf_core::encoding::hash_grid::{Corners, Level};
use pocketnerf_core::lanes::LANES;

/// Adds the gradient of `n` points (a multiple of 16) to one level's table.
///
/// `rows` holds the gradient of the level's features, `[features][stride]`.
/// `table` is `[entries][features]`.
#[inline(always)]
pub(super) fn scatter_level<S: Simd>(
    simd: S,
    level: &Level,
    features: usize,
    points: [&[f32]; 3],
    rows: &[f32],
    stride: usize,
    table: &mut [f32],
) {
    simd.vectorize(
        #[inline(always)]
        || match features {
            1 => scatter_singles::<S, 1>(simd, level, points, rows, stride, table),
            2 => scatter_singles::<S, 2>(simd, level, points, rows, stride, table),
            4 => scatter_quads::<S, 4>(simd, level, points, rows, stride, table),
            _ => scatter_quads::<S, 8>(simd, level, points, rows, stride, table),
        },
    );
}

#[inline(always)]
fn scatter_quads<S: Simd, const F: usize>(
    simd: S,
    level: &Level,
    points: [&[f32]; 3],
    rows: &[f32],
    stride: usize,
    table: &mut [f32],
) {
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let entries = table.as_chunks_mut::<F>().0;
    let entries = &mut entries[..level.entries as usize];
    let mut corners = Corners::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        corners.find(simd, level, [x, y, z], 1.0);
        for quad in 0..F / 4 {
            let row = |f: usize| &rows[(quad * 4 + f) * stride + g * LANES..][..LANES];
            let (r0, r1, r2, r3) = (row(0), row(1), row(2), row(3));
            for s in 0..LANES {
                let gradient = f32x4::load_array(simd, [r0[s], r1[s], r2[s], r3[s]]);
                for c in 0..8 {
                    let entry = &mut entries[corners.entry[c][s] as usize];
                    let weight = f32x4::splat(simd, corners.weight[c][s]);
                    let to = &mut entry.as_chunks_mut::<4>().0[quad];
                    let sum = gradient.mul_add(weight, f32x4::load_array_ref(simd, to));
                    sum.store_array(to);
                }
            }
        }
    }
}

#[inline(always)]
fn scatter_singles<S: Simd, const F: usize>(
    simd: S,
    level: &Level,
    points: [&[f32]; 3],
    rows: &[f32],
    stride: usize,
    table: &mut [f32],
) {
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let entries = table.as_chunks_mut::<F>().0;
    let mut corners = Corners::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        corners.find(simd, level, [x, y, z], 1.0);
        for s in 0..LANES {
            for c in 0..8 {
                let entry = &mut entries[corners.entry[c][s] as usize];
                for (f, value) in entry.iter_mut().enumerate() {
                    *value += corners.weight[c][s] * rows[f * stride + g * LANES + s];
                }
            }
        }
    }
}
