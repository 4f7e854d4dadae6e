//! The gradient of planes and lines: that of encoded points, added to the entries they read.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8};
use pocketnerf_core::encoding::planes::{FEATURES, Pair, Places, each};
use pocketnerf_core::lanes::{LANES, transpose};
use pocketnerf_core::store::Store;

/// Adds the gradient of a multiple of 16 points to that of a pair, the plane's first.
///
/// `rows` holds the gradient of the pair's products, `[FEATURES][stride]`.
#[inline(always)]
pub(super) fn scatter_pair<S: Simd, T: Store>(
    simd: S,
    (pair, axis, resolution): (Pair<'_>, usize, u32),
    points: [&[f32]; 3],
    (rows, stride): (&[f32], usize),
    gradient: &mut [f32],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let entries = gradient.as_chunks_mut::<FEATURES>().0;
            let (plane, line) = entries.split_at_mut((resolution * resolution) as usize);
            let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
            let mut places = Places::ZERO;
            let mut of_points = [0.0; LANES * LANES];
            let around = [0, 1, resolution, resolution + 1];
            for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
                places.find(resolution, [x, y, z]);
                let own = (&rows[g * LANES..], stride, FEATURES);
                transpose(simd, own, (&mut of_points, LANES), LANES);
                each::<T, 1, FEATURES>(
                    &[pair],
                    (axis, resolution),
                    &places,
                    |s, on_plane, on_line| {
                        let by_product = &of_points[s * LANES..][..FEATURES];
                        let by_product = f32x8::from_slice(simd, by_product);
                        let add = |entry: &mut [f32; FEATURES], weight: f32, by: f32x8<S>| {
                            let sum = f32x8::load_array_ref(simd, entry);
                            by.mul_add(f32x8::splat(simd, weight), sum).store_array(entry);
                        };
                        let by_plane = by_product * f32x8::load_array(simd, on_line);
                        for (weights, behind) in places.plane_weights[axis].iter().zip(around) {
                            let entry = places.on_plane[axis][s] + behind;
                            add(&mut plane[entry as usize], weights[s], by_plane);
                        }
                        let by_line = by_product * f32x8::load_array(simd, on_plane);
                        for (weights, behind) in places.line_weights[axis].iter().zip([0, 1]) {
                            let entry = places.on_line[axis][s] + behind;
                            add(&mut line[entry as usize], weights[s], by_line);
                        }
                    },
                );
            }
        },
    );
}
