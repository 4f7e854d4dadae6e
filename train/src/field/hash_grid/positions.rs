//! The gradient of points: back through the interpolation between the grid's corners.

use fearless_simd::Simd;
use pocketnerf_core::encoding::hash_grid::{Corners, Level};
use pocketnerf_core::lanes::LANES;

/// Adds the gradient through one level, times a share, to that of a multiple of 16 `points`.
///
/// `table` is `[entries][features]`; `rows` holds the gradient of the level's features,
/// `[features][stride]`.
#[inline(always)]
pub(super) fn add_level<S: Simd>(
    simd: S,
    level: (&Level, f32),
    (table, rows, (features, stride)): (&[f32], &[f32], (usize, usize)),
    points: [&[f32]; 3],
    d_points: &mut [&mut [f32]; 3],
) {
    simd.vectorize(
        #[inline(always)]
        || match features {
            1 => add::<S, 1>(simd, level, (table, rows, stride), points, d_points),
            2 => add::<S, 2>(simd, level, (table, rows, stride), points, d_points),
            4 => add::<S, 4>(simd, level, (table, rows, stride), points, d_points),
            _ => add::<S, 8>(simd, level, (table, rows, stride), points, d_points),
        },
    );
}

#[inline(always)]
fn add<S: Simd, const F: usize>(
    simd: S,
    (level, share): (&Level, f32),
    (table, rows, stride): (&[f32], &[f32], usize),
    points: [&[f32]; 3],
    d_points: &mut [&mut [f32]; 3],
) {
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let entries = &table.as_chunks::<F>().0[..level.entries as usize];
    let mut corners = Corners::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        corners.find(simd, level, [x, y, z], 1.0);
        // What more of each corner would add to the loss.
        let mut worth = [[0.0; LANES]; 8];
        for (worth, numbers) in worth.iter_mut().zip(&corners.entry) {
            for (s, (worth, number)) in worth.iter_mut().zip(numbers).enumerate() {
                let entry = &entries[*number as usize];
                let row = |f: usize| rows[f * stride + g * LANES + s];
                *worth = (0..F).map(|f| row(f) * entry[f]).sum();
            }
        }
        for (axis, d_point) in d_points.iter_mut().enumerate() {
            let to = &mut d_point[g * LANES..][..LANES];
            for low in (0..8).filter(|c| c >> axis & 1 == 0) {
                let high = low | 1 << axis;
                for (s, to) in to.iter_mut().enumerate() {
                    // Together the weights are that of the edge between both corners.
                    let weight = corners.weight[low][s] + corners.weight[high][s];
                    *to += share * level.scale * weight * (worth[high][s] - worth[low][s]);
                }
            }
        }
    }
}
