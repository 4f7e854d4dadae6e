//! Planes and lines: a volume as a sum of products (Chen et al. 2022, "TensoRF", section 3,
//! vector-matrix decomposition), bilinear and linear.
//!
//! Along each axis there is a line of `resolution` entries, and across it a plane of
//! `resolution²`; a point u lies at position `u * (resolution - 1)` of each. An encoded value is
//! the product of what the plane and the line hold there. Entries have [`FEATURES`] values; for
//! more components an axis has several pairs of a plane and a line.

use fearless_simd::Simd;

use crate::lanes::{LANES, transpose};
use crate::store::{F16, F32, I8, Store};
use crate::{DType, Error, TensorView};

/// Values of an entry.
pub const FEATURES: usize = 8;
/// Most pairs of a plane and a line: 32 components along each axis.
pub const MAX_PAIRS: usize = 12;
/// Fewest and most entries along an axis.
pub const RESOLUTIONS: core::ops::RangeInclusive<u32> = 2..=2048;

/// From here on f32 has whole numbers only, one for each of its bits: 2^23.
const WHOLE: f32 = 8_388_608.0;

/// Values that are encoded together: of two pairs where registers may hold so many, else of one.
const TOGETHER: usize = if cfg!(target_arch = "x86_64") { LANES } else { FEATURES };

/// Planes and lines.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a> {
    /// Entries along an axis.
    pub resolution: u32,
    /// Products along each axis: 16 or 32.
    pub n_components: u32,
    /// As many as [`n_pairs`](Self::n_pairs) says: those of x first, then of y, of z.
    pub pairs: [Pair<'a>; MAX_PAIRS],
}

/// A plane and the line across it.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// `[resolution², FEATURES]`. Of the two other axes the first one runs fastest: across x,
    /// entry (y, z) is number `y + resolution * z`.
    pub plane: TensorView<'a>,
    /// `[resolution, FEATURES]`.
    pub line: TensorView<'a>,
}

impl Pair<'_> {
    /// Neither.
    pub const EMPTY: Self = Self { plane: TensorView::EMPTY, line: TensorView::EMPTY };
}

/// The two axes of the plane across an axis.
pub const ACROSS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

impl Planes<'_> {
    /// Pairs of so many components along each axis.
    #[must_use]
    pub const fn n_pairs(n_components: u32) -> usize {
        3 * (n_components as usize / FEATURES)
    }

    /// The axis along which the line of a pair lies.
    #[must_use]
    pub const fn axis(n_components: u32, pair: usize) -> usize {
        pair / (n_components as usize / FEATURES)
    }

    /// Values of an encoded point: value v of pair p is number `FEATURES * p + v`.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        3 * self.n_components as usize
    }

    /// Checks sizes and types.
    ///
    /// # Errors
    /// [`Error::Range`] or [`Error::Shape`].
    pub fn validate(&self) -> Result<(), Error> {
        if !RESOLUTIONS.contains(&self.resolution) {
            return Err(Error::Range("planes: resolution, from 2 to 2048"));
        }
        if !matches!(self.n_components, 16 | 32) {
            return Err(Error::Range("planes: components, 16 or 32"));
        }
        let n = self.resolution;
        let dtype = self.pairs[0].plane.dtype();
        for Pair { plane, line } in &self.pairs[..Self::n_pairs(self.n_components)] {
            if plane.shape() != [n * n, FEATURES as u32] || line.shape() != [n, FEATURES as u32] {
                return Err(Error::Shape("planes and lines, and their resolution"));
            }
            if [plane, line].iter().any(|t| t.dtype() != dtype || t.dtype() == DType::U16) {
                return Err(Error::Shape("planes: the type of values"));
            }
        }
        Ok(())
    }
}

/// Where 16 points lie on the planes and lines.
#[derive(Clone, Copy, Debug)]
pub struct Places {
    /// The entry before point s on the line along an axis: `on_line[axis][s]`; the next one is
    /// the one behind it.
    pub on_line: [[u32; LANES]; 3],
    /// Their weights.
    pub line_weights: [[[f32; LANES]; 2]; 3],
    /// The first of the four entries around point s of the plane across an axis. The others:
    /// plus 1, plus `resolution`, plus both.
    pub on_plane: [[u32; LANES]; 3],
    /// Their weights.
    pub plane_weights: [[[f32; LANES]; 4]; 3],
}

impl Places {
    /// Room for a group.
    pub const ZERO: Self = Self {
        on_line: [[0; LANES]; 3],
        line_weights: [[[0.0; LANES]; 2]; 3],
        on_plane: [[0; LANES]; 3],
        plane_weights: [[[0.0; LANES]; 4]; 3],
    };

    /// Places 16 points, clamped to the unit cube; NaN counts as 0.
    // Elsewhere instructions are known to the whole program, and one copy is enough.
    #[cfg_attr(target_arch = "x86_64", inline(always))]
    #[allow(clippy::manual_clamp, reason = "`clamp` keeps NaN")]
    pub fn find(&mut self, resolution: u32, points: [&[f32; LANES]; 3]) {
        let (scale, last) = ((resolution - 1) as f32, resolution - 2);
        for (axis, points) in points.iter().enumerate() {
            for s in 0..LANES {
                // max first: NaN becomes 0.
                let position = points[s].max(0.0).min(1.0) * scale;
                // The last cell has its far side too.
                let cell = floor(position).min(last);
                let fraction = position - cell as f32;
                self.on_line[axis][s] = cell;
                self.line_weights[axis][0][s] = 1.0 - fraction;
                self.line_weights[axis][1][s] = fraction;
            }
        }
        for (axis, [first, second]) in ACROSS.into_iter().enumerate() {
            for s in 0..LANES {
                let (low, high) = (self.on_line[first][s], self.on_line[second][s]);
                self.on_plane[axis][s] = low + resolution * high;
                for corner in 0..4 {
                    self.plane_weights[axis][corner][s] = self.line_weights[first][corner & 1][s]
                        * self.line_weights[second][corner >> 1][s];
                }
            }
        }
    }
}

/// The whole number below a position.
#[inline(always)]
fn floor(position: f32) -> u32 {
    // Compilers convert lane by lane for some machines: by f32's exponent instead.
    let nearest = (position + WHOLE) - WHOLE;
    let below = if nearest > position { nearest - 1.0 } else { nearest };
    (below + WHOLE).to_bits() - WHOLE.to_bits()
}

/// Encodes points: writes `n_output` rows of `x.len()` values.
///
/// `points` are unit coordinates (clamped to [0, 1]; NaN counts as 0), a multiple of 16 of them.
/// Value v of point s goes to `out[v * stride + s]`.
#[inline(always)]
pub fn encode<S: Simd>(
    simd: S,
    planes: &Planes<'_>,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    match planes.pairs[0].plane.dtype() {
        DType::F32 => encode_stored::<S, F32>(simd, planes, points, out, stride),
        DType::F16 => encode_stored::<S, F16>(simd, planes, points, out, stride),
        // `validate` refuses all others.
        _ => encode_stored::<S, I8>(simd, planes, points, out, stride),
    }
}

#[inline(always)]
fn encode_stored<S: Simd, T: Store>(
    simd: S,
    planes: &Planes<'_>,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let n_pairs = Planes::n_pairs(planes.n_components);
            let [x, y, z] = points.map(|p| p.as_chunks::<LANES>().0);
            let mut places = Places::ZERO;
            let mut products = [[0.0; LANES]; LANES];
            for (g, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
                places.find(planes.resolution, [x, y, z]);
                // Two pairs of an axis fill the rows of a transposition.
                for (two, pairs) in planes.pairs[..n_pairs].as_chunks().0.iter().enumerate() {
                    let axis = Planes::axis(planes.n_components, 2 * two);
                    let (shape, pairs): (_, &[_; 2]) = ((axis, planes.resolution), pairs);
                    for (part, pairs) in pairs.as_chunks().0.iter().enumerate() {
                        let give = |s: usize, plane: [f32; TOGETHER], line: [f32; TOGETHER]| {
                            for v in 0..TOGETHER {
                                products[s][part * TOGETHER + v] = plane[v] * line[v];
                            }
                        };
                        each::<T, { TOGETHER / FEATURES }, TOGETHER>(pairs, shape, &places, give);
                    }
                    let out = &mut out[two * LANES * stride + g * LANES..];
                    let rows = (products.as_flattened(), LANES, LANES);
                    transpose(simd, rows, (out, stride), LANES);
                }
            }
        },
    );
}

/// What the planes and the lines of `PAIRS` pairs along one axis hold at each of 16 points, in
/// order: a point at a time, a value in every lane, because entries lie anywhere in memory, but
/// their values together. `VALUES` is how many all pairs have.
///
/// `T` is how all are stored, `shape` the axis of the lines and the resolution.
#[inline(always)]
pub fn each<T: Store, const PAIRS: usize, const VALUES: usize>(
    pairs: &[Pair<'_>; PAIRS],
    shape: (usize, u32),
    places: &Places,
    mut give: impl FnMut(usize, [f32; VALUES], [f32; VALUES]),
) {
    const { assert!(VALUES == PAIRS * FEATURES) };
    let (axis, resolution) = shape;
    let planes = Tables::<T, PAIRS, VALUES>::of(pairs.each_ref().map(|pair| &pair.plane));
    let lines = Tables::<T, PAIRS, VALUES>::of(pairs.each_ref().map(|pair| &pair.line));
    let around = [0, 1, resolution, resolution + 1];
    for s in 0..LANES {
        let (mut on_plane, mut on_line) = ([0.0f32; VALUES], [0.0f32; VALUES]);
        for (weights, behind) in places.plane_weights[axis].iter().zip(around) {
            planes.add(places.on_plane[axis][s] + behind, weights[s], &mut on_plane);
        }
        for (weights, behind) in places.line_weights[axis].iter().zip([0, 1]) {
            lines.add(places.on_line[axis][s] + behind, weights[s], &mut on_line);
        }
        for v in 0..VALUES {
            on_plane[v] *= planes.factors[v];
            on_line[v] *= lines.factors[v];
        }
        give(s, on_plane, on_line);
    }
}

/// The planes of some pairs, or their lines.
struct Tables<'a, T: Store, const PAIRS: usize, const VALUES: usize> {
    entries: [&'a [[T::Bits; FEATURES]]; PAIRS],
    /// What decoded values are still to be multiplied by.
    factors: [f32; VALUES],
}

impl<'a, T: Store, const PAIRS: usize, const VALUES: usize> Tables<'a, T, PAIRS, VALUES> {
    #[inline(always)]
    fn of(tables: [&TensorView<'a>; PAIRS]) -> Self {
        let factor = |v: usize| tables[v / FEATURES].scale() * T::FACTOR;
        let entries = tables.map(|table| T::values(table.bytes()).as_chunks::<FEATURES>().0);
        Self { entries, factors: core::array::from_fn(factor) }
    }

    /// Adds the values of an entry of each, times a weight.
    #[inline(always)]
    fn add(&self, entry: u32, weight: f32, sums: &mut [f32; VALUES]) {
        // Together in a register.
        let mut values = [0.0; VALUES];
        for (to, entries) in values.as_chunks_mut::<FEATURES>().0.iter_mut().zip(self.entries) {
            for (to, value) in to.iter_mut().zip(&entries[entry as usize]) {
                *to = T::decode_divided(*value);
            }
        }
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, those just below and above, and what lies outside.
    #[test]
    fn cells_are_those_below() {
        for resolution in [2, 3, 300, 2048] {
            let scale = (resolution - 1) as f32;
            for i in 0..resolution {
                let at = i as f32 / scale;
                let mut points = [at, at.next_down(), at.next_up(), -at, 1.0 + at, f32::NAN];
                points.rotate_left(i as usize % 6);
                let points: [f32; LANES] = core::array::from_fn(|s| points[s % 6]);
                let mut places = Places::ZERO;
                places.find(resolution, [&points; 3]);
                for (s, point) in points.iter().enumerate() {
                    let position = if point.is_nan() { 0.0 } else { point.clamp(0.0, 1.0) * scale };
                    let cell = (position as u32).min(resolution - 2);
                    let fraction = position - cell as f32;
                    assert_eq!(places.on_line[2][s], cell, "{point} of {resolution}");
                    assert_eq!(places.on_plane[1][s], cell + resolution * cell);
                    let weights = places.line_weights[0].map(|weights| weights[s]);
                    assert_eq!(weights, [1.0 - fraction, fraction]);
                }
            }
        }
    }
}
