//! Multiresolution hash grid (Müller et al. 2022, "Instant neural graphics
//! primitives", section 3), trilinear.
//!
//! Names are tiny-cuda-nn's. Level l has `scale_l = base_resolution *
//! per_level_scale^l - 1` cells along a unit length; a point u lies at grid
//! position `u * scale_l + 0.5`, between the corners `floor` and `floor + 1`.

mod shape;

pub use shape::{CornerLevel, CornerLevels};
pub use shape::{
    GridIndex, HASH_PRIMES, HashGrid, HashGridConfig, Level, MAX_FEATURES_PER_LEVEL, MAX_LEVELS,
};

use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat, SimdInt};

use crate::lanes::LANES;
use crate::store::{F16, F32, I8, Store};
use crate::{DType, TensorView};

/// Encodes points: writes `n_output` rows of `x.len()` values.
///
/// `x`, `y`, `z` are unit coordinates (clamped to [0, 1]; NaN counts as 0), a
/// multiple of 16 of them. Feature f of level l of point s goes to
/// `out[(l * F + f) * stride + s]`.
#[inline(always)]
pub fn encode<S: Simd>(
    simd: S,
    grid: &HashGrid<'_>,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    let features = grid.config.n_features_per_level as usize;
    for (l, table) in grid.levels.iter().enumerate().take(grid.config.n_levels as usize) {
        let level = grid.config.level(l);
        let out = &mut out[l * features * stride..];
        // One call a level: the level's table stays in the cache.
        match table.dtype() {
            DType::F32 => encode_table::<S, F32>(simd, &level, table, points, out, stride),
            DType::F16 => encode_table::<S, F16>(simd, &level, table, points, out, stride),
            // `validate` refuses all others.
            DType::I8 | DType::U16 => {
                encode_table::<S, I8>(simd, &level, table, points, out, stride);
            }
        }
    }
}

#[inline(always)]
fn encode_table<S: Simd, T: Store>(
    simd: S,
    level: &Level,
    table: &TensorView<'_>,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    let (entries, features) = (level.entries as usize, table.cols());
    let values = T::values(table.bytes());
    // Slices of the wrong size would have been refused by `validate`.
    if features == QUAD {
        let entries = &values.as_chunks::<QUAD>().0[..entries];
        simd.vectorize(
            #[inline(always)]
            || {
                let factor = table.scale() * T::FACTOR;
                each_group(simd, level, points, factor, |g, corners| {
                    let rows = interpolate_quads::<S, T>(simd, entries, corners);
                    for (f, row) in rows.iter().enumerate() {
                        out[f * stride + g * LANES..][..LANES].copy_from_slice(row);
                    }
                });
            },
        );
    } else {
        let values = &values[..entries * features];
        simd.vectorize(
            #[inline(always)]
            || {
                each_group(simd, level, points, table.scale(), |g, corners| {
                    for f in 0..features {
                        let row = interpolate_single::<T>(values, features, f, corners);
                        out[f * stride + g * LANES..][..LANES].copy_from_slice(&row);
                    }
                });
            },
        );
    }
}

/// Features of an entry for which there is a kernel of its own.
const QUAD: usize = 4;

/// The eight corners around each of 16 points: entry numbers and trilinear
/// weights. Corner c is `floor + (c & 1, c >> 1 & 1, c >> 2)`.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    /// Entry of corner c of point s: `entry[c][s]`.
    pub entry: [[u32; LANES]; 8],
    /// Its weight, times the factor given.
    pub weight: [[f32; LANES]; 8],
}

impl Corners {
    /// Room for a group.
    pub const ZERO: Self = Self { entry: [[0; LANES]; 8], weight: [[0.0; LANES]; 8] };

    /// Finds the corners of 16 points; weights are multiplied by `factor`.
    #[inline(always)]
    pub fn find<S: Simd>(
        &mut self,
        simd: S,
        level: &Level,
        points: [&[f32; LANES]; 3],
        factor: f32,
    ) {
        let by_corner = level.is_by_corner();
        let multipliers = match level.dense_side {
            0 => HASH_PRIMES,
            side => [1, side, side * side],
        };
        let grid = [level.scale, level.shift()];
        let n = S::f32s::LEN;
        for lane in (0..LANES).step_by(n) {
            let mut axes = self.weigh(simd, grid, points, factor, lane);
            for (axis, corners) in axes.iter_mut().enumerate() {
                for corner in corners {
                    let term = *corner * multipliers[axis];
                    *corner = if by_corner {
                        term
                    } else {
                        in_blocks(*corner, multipliers[axis], axis as u32)
                    };
                }
            }
            let [x, y, z] = axes;
            for (c, entries) in self.entry.iter_mut().enumerate() {
                let (x, y, z) = (x[c & 1], y[c >> 1 & 1], z[c >> 2]);
                let entry = if level.dense_side > 0 {
                    let entry = x + y + z;
                    // The corner behind the last of a row is the first of the next one,
                    // and behind the last of all come the first: less than zero is huge.
                    if by_corner { entry.min(entry - level.entries) } else { entry }
                } else {
                    (x ^ y ^ z) & (level.entries - 1)
                };
                entry.store_slice(&mut entries[lane..lane + n]);
            }
        }
    }

    /// Weighs the corners around points from `lane` on, in a grid where points lie at
    /// `u * scale + shift`. Returns the corners' coordinates: below and above, along each axis.
    #[inline(always)]
    pub(super) fn weigh<S: Simd>(
        &mut self,
        simd: S,
        [scale, shift]: [f32; 2],
        points: [&[f32; LANES]; 3],
        factor: f32,
        lane: usize,
    ) -> [[S::u32s; 2]; 3] {
        let lanes = lane..lane + S::f32s::LEN;
        let one = S::f32s::splat(simd, 1.0);
        let mut coordinates = [[S::u32s::splat(simd, 0); 2]; 3];
        let mut weight = [[one; 2]; 3];
        for axis in 0..3 {
            let u = S::f32s::from_slice(simd, &points[axis][lanes.clone()]);
            // max first: NaN becomes 0.
            let u = u.max_precise(0.0).min(one);
            let p = u.mul_add(S::f32s::splat(simd, scale), S::f32s::splat(simd, shift));
            let floor = p.floor();
            let fraction = p - floor;
            let corner: S::u32s = floor.to_int::<S::i32s>().bitcast();
            coordinates[axis] = [corner, corner + 1];
            weight[axis] = [one - fraction, fraction];
        }
        for w in &mut weight[0] {
            *w *= factor;
        }
        for c in 0..8 {
            let w = weight[0][c & 1] * weight[1][c >> 1 & 1] * weight[2][c >> 2];
            w.store_slice(&mut self.weight[c][lanes.clone()]);
        }
        coordinates
    }
}

/// One axis's part of an entry number: block coordinate times multiplier above
/// the three low bits, the coordinate's lowest bit in place `axis`. Parts are
/// joined by + on dense levels and by xor on hashed ones.
#[inline(always)]
fn in_blocks<V: SimdInt<S, Element = u32>, S: Simd>(corner: V, multiplier: u32, axis: u32) -> V {
    (((corner >> 1) * multiplier) << 3) | ((corner & 1) << axis)
}

/// Finds the corners of each group of points, in order.
#[inline(always)]
fn each_group<S: Simd>(
    simd: S,
    level: &Level,
    points: [&[f32]; 3],
    factor: f32,
    mut interpolate: impl FnMut(usize, &Corners),
) {
    let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
    let mut corners = Corners::ZERO;
    for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        corners.find(simd, level, [x, y, z], factor);
        interpolate(g, &corners);
    }
}

/// Sums a group's corners where entries have four features. Entries are first
/// copied together as they are, so that many reads are on their way at a time,
/// and then decoded with a point in every lane.
#[inline(always)]
fn interpolate_quads<S: Simd, T: Store>(
    simd: S,
    entries: &[[T::Bits; QUAD]],
    corners: &Corners,
) -> [[f32; LANES]; QUAD] {
    let mut rows = [[0.0f32; LANES]; QUAD];
    let n = S::f32s::LEN;
    for lane in (0..LANES).step_by(n) {
        let lanes = lane..lane + n;
        let mut sums = [S::f32s::splat(simd, 0.0); QUAD];
        for (numbers, weights) in corners.entry.iter().zip(&corners.weight) {
            let mut quads = [T::Quad::default(); LANES];
            for (to, number) in quads[..n].iter_mut().zip(&numbers[lanes.clone()]) {
                *to = T::quad(&entries[*number as usize]);
            }
            let weight = S::f32s::from_slice(simd, &weights[lanes.clone()]);
            let values = T::decode_quads(simd, &quads[..n]);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum = value.mul_add(weight, *sum);
            }
        }
        for (row, sum) in rows.iter_mut().zip(sums) {
            sum.store_slice(&mut row[lanes.clone()]);
        }
    }
    rows
}

/// The sum of feature `f` over a group's corners, of any number of features.
#[inline(always)]
fn interpolate_single<T: Store>(
    values: &[T::Bits],
    features: usize,
    f: usize,
    corners: &Corners,
) -> [f32; LANES] {
    let mut row = [0.0f32; LANES];
    for (numbers, weights) in corners.entry.iter().zip(&corners.weight) {
        for ((sum, number), weight) in row.iter_mut().zip(numbers).zip(weights) {
            *sum += weight * T::decode(values[*number as usize * features + f]);
        }
    }
    row
}
