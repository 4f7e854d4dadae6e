//! Sparse grid of voxels, trilinear (Fridovich-Keil et al. 2022, "Plenoxels", section 3.1).
//!
//! `resolution` voxels lie along a unit length; a point u lies at grid position
//! `u * resolution`, between the corners `floor` and `floor + 1`. Corners are kept in bricks
//! of 4 x 4 x 4, and only of bricks that hold something: an index gives the number of each,
//! row after row along x, then y, then z. Number 0 is a brick for all that hold nothing.

use fearless_simd::{Simd, SimdBase};

use super::hash_grid::Corners;
use crate::lanes::{LANES, transpose};
use crate::store::{F16, F32, I8, Store};
use crate::{DType, Error, TensorView};

/// Corners along an axis of a brick.
pub const BRICK_SIDE: u32 = 4;
/// Corners of a brick.
pub const BRICK: usize = 64;
/// Most voxels along a unit length.
pub const MAX_RESOLUTION: u32 = 512;

/// A sparse grid of voxels.
#[derive(Clone, Copy, Debug)]
pub struct VoxelGrid<'a> {
    /// Voxels along a unit length: a multiple of 4, from 4 to [`MAX_RESOLUTION`].
    pub resolution: u32,
    /// Numbers of the bricks, [`DType::U16`], `[bricks_along³, 1]`.
    pub index: TensorView<'a>,
    /// Values of the corners of all bricks that are kept, `[64 * bricks, values]`. Corner
    /// (x, y, z) of a brick is number `x + 4 y + 16 z`. Of each 4, 16 or 32.
    pub values: TensorView<'a>,
}

/// Bricks along an axis of a grid of so many voxels: corners 0 to `resolution + 1` have one.
#[must_use]
pub const fn bricks_along(resolution: u32) -> u32 {
    resolution / BRICK_SIDE + 1
}

impl VoxelGrid<'_> {
    /// Values of a corner.
    #[must_use]
    pub const fn n_values(&self) -> usize {
        self.values.cols()
    }

    /// Checks sizes and types, but not that each number has its brick: reading one that has
    /// none reads the last.
    ///
    /// # Errors
    /// [`Error::Range`] or [`Error::Shape`].
    pub fn validate(&self) -> Result<(), Error> {
        let resolution = self.resolution;
        if !(BRICK_SIDE..=MAX_RESOLUTION).contains(&resolution)
            || !resolution.is_multiple_of(BRICK_SIDE)
        {
            return Err(Error::Range("voxel grid resolution: a multiple of 4, from 4 to 512"));
        }
        if self.index.shape() != [bricks_along(resolution).pow(3), 1]
            || self.index.dtype() != DType::U16
        {
            return Err(Error::Shape("voxel grid: the index and the resolution"));
        }
        let (corners, values) = (self.values.rows(), self.values.cols());
        let whole = corners.is_multiple_of(BRICK) && matches!(values, 4 | 16 | 32);
        if !whole || corners == 0 || corners / BRICK > 1 << 16 {
            return Err(Error::Shape("voxel grid: values of whole bricks"));
        }
        if self.values.dtype() == DType::U16 {
            return Err(Error::Shape("voxel grid: the type of values"));
        }
        Ok(())
    }

    /// Finds the corners around 16 points, as numbers of rows of `values`, which need not be
    /// there; weights are multiplied by `factor`. Corner c is `floor + (c & 1, c >> 1 & 1, c >> 2)`.
    #[inline(always)]
    pub fn place<S: Simd>(
        &self,
        simd: S,
        points: [&[f32; LANES]; 3],
        factor: f32,
        corners: &mut Corners,
    ) {
        let along = bricks_along(self.resolution);
        let multipliers = [1, along, along * along];
        let n = S::f32s::LEN;
        for lane in (0..LANES).step_by(n) {
            let mut axes = corners.weigh(simd, [self.resolution as f32, 0.0], points, factor, lane);
            for (axis, corners) in axes.iter_mut().enumerate() {
                for corner in corners {
                    // A brick's place above the six bits of a corner's place in it.
                    let brick = (*corner >> 2) * multipliers[axis];
                    *corner = (brick << 6) | ((*corner & 3) << (2 * axis as u32));
                }
            }
            let [x, y, z] = axes;
            for (c, places) in corners.entry.iter_mut().enumerate() {
                let place = x[c & 1] + y[c >> 1 & 1] + z[c >> 2];
                place.store_slice(&mut places[lane..lane + n]);
            }
        }
        let index = self.index.bytes().as_chunks::<2>().0;
        for places in &mut corners.entry {
            for place in places {
                let number = u16::from_le_bytes(index[(*place >> 6) as usize]);
                *place = u32::from(number) << 6 | (*place & 63);
            }
        }
    }
}

/// Interpolates at points: writes a row of `x.len()` values for each value of a corner.
///
/// `points` are unit coordinates (clamped to [0, 1]; NaN counts as 0), a multiple of 16 of them.
/// Value v of point s goes to `out[v * stride + s]`.
#[inline(always)]
pub fn interpolate<S: Simd>(
    simd: S,
    grid: &VoxelGrid<'_>,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let factor = grid.values.scale() * factor(grid.values.dtype());
            let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
            let mut corners = Corners::ZERO;
            for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
                grid.place(simd, [x, y, z], factor, &mut corners);
                if grid.n_values() == QUAD {
                    let sums: [[f32; QUAD]; LANES] = sum(simd, grid, &corners, 0);
                    for v in 0..QUAD {
                        let row = &mut out[v * stride + g * LANES..][..LANES];
                        row.iter_mut().zip(&sums).for_each(|(to, sums)| *to = sums[v]);
                    }
                    continue;
                }
                for part in 0..grid.n_values() / LANES {
                    let sums: [[f32; LANES]; LANES] = sum(simd, grid, &corners, part);
                    let out = &mut out[part * LANES * stride + g * LANES..];
                    transpose(simd, (sums.as_flattened(), LANES, LANES), (out, stride), LANES);
                }
            }
        },
    );
}

/// Values of a corner that fill no wide register.
const QUAD: usize = 4;

/// What values as [`sum`] reads them are still to be multiplied by, beside their scale.
#[inline(always)]
const fn factor(dtype: DType) -> f32 {
    match dtype {
        DType::F32 => F32::FACTOR,
        DType::F16 => F16::FACTOR,
        // `validate` refuses all others.
        _ => I8::FACTOR,
    }
}

/// Sums of `V` values of each point's corners, the `part`-th so many.
#[inline(always)]
fn sum<S: Simd, const V: usize>(
    simd: S,
    grid: &VoxelGrid<'_>,
    corners: &Corners,
    part: usize,
) -> [[f32; V]; LANES] {
    match grid.values.dtype() {
        DType::F32 => sum_stored::<S, F32, V>(simd, grid, corners, part),
        DType::F16 => sum_stored::<S, F16, V>(simd, grid, corners, part),
        _ => sum_stored::<S, I8, V>(simd, grid, corners, part),
    }
}

/// A point at a time, a value in every lane: corners lie anywhere in memory, but their values
/// together.
#[inline(always)]
fn sum_stored<S: Simd, T: Store, const V: usize>(
    simd: S,
    grid: &VoxelGrid<'_>,
    corners: &Corners,
    part: usize,
) -> [[f32; V]; LANES] {
    let values = T::values(grid.values.bytes()).as_chunks::<V>().0;
    let parts = grid.n_values() / V;
    // A number without a brick counts as the last one's.
    let last = grid.values.rows() as u32 - 1;
    let n = S::f32s::LEN;
    let mut sums = [[0.0f32; V]; LANES];
    for (s, sums) in sums.iter_mut().enumerate() {
        // Registers by hand where they are full: compilers gather values of many points instead.
        let mut registers = [S::f32s::splat(simd, 0.0); LANES];
        for (entry, weight) in corners.entry.iter().zip(&corners.weight) {
            let row = &values[entry[s].min(last) as usize * parts + part];
            let mut decoded = [0.0f32; V];
            for (to, value) in decoded.iter_mut().zip(row) {
                *to = T::decode_divided(*value);
            }
            if V < n {
                for (sum, value) in sums.iter_mut().zip(decoded) {
                    *sum += weight[s] * value;
                }
            }
            for (register, value) in registers.iter_mut().zip(decoded.chunks_exact(n)) {
                *register += S::f32s::from_slice(simd, value) * weight[s];
            }
        }
        for (register, to) in registers.iter().zip(sums.chunks_exact_mut(n)) {
            register.store_slice(to);
        }
    }
    sums
}
