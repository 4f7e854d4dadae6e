//! Dense layers in whole numbers: x86 processors multiply pairs of 16-bit numbers and add
//! the products in the time of one multiplication in f32.
//!
//! A point's values are rounded to 14 bits of the largest of them, an output's weights to as
//! many as let no sum overflow: about 14, where f16 has 11. Sums are exact.

use core::ops::Range;

use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat, SimdInt, f32x8, i32x8};

use super::{Dense, PANEL, finish_row, load_bias, load_panel, panel_len};
use crate::DType;
use crate::store::F16;

/// Most that a value of a point is.
const MOST: f32 = 8191.0;
/// Most that an output's weights sum up to: with half a unit of rounding for each of 4096, and
/// times [`MOST`], just below 2^31.
const MOST_SUM: f32 = 260_000.0;
/// Most that a weight is.
const MOST_WEIGHT: f32 = 32_767.0;
/// Less than any unit is, by which nothing could be divided.
const LEAST: f32 = 1e-30;
/// In f32, x + 1.5 * 2^23 ends with the bits of the whole number next to x.
const WHOLE: f32 = 12_582_912.0;
/// Half the outputs of a panel.
const HALF: usize = PANEL / 2;

/// Pairs of 16-bit numbers in 32 bits.
pub(super) trait Pairs: Simd {
    /// Whether the registers hold the sums of a whole panel at two registers of points.
    const WHOLE_PANELS: bool;

    /// `sum` and both products of each lane's pairs.
    fn add_products(self, sum: Self::i32s, x: Self::i32s, w: Self::i32s) -> Self::i32s;
}

mod x86 {
    #[cfg(target_arch = "x86")]
    use core::arch::x86::{_mm256_add_epi32, _mm256_madd_epi16, _mm512_dpwssd_epi32};
    #[cfg(target_arch = "x86_64")]
    use core::arch::x86_64::{_mm256_add_epi32, _mm256_madd_epi16, _mm512_dpwssd_epi32};

    use fearless_simd::{Avx2, Avx512, SimdInto, i32x8, i32x16};

    type Sixteen = i32x16<Avx512>;
    type Eight = i32x8<Avx2>;

    fearless_simd::kernel!(
        #[inline]
        fn sixteen(avx512: Avx512, sum: Sixteen, x: Sixteen, w: Sixteen) -> Sixteen {
            _mm512_dpwssd_epi32(sum.into(), x.into(), w.into()).simd_into(avx512)
        }
    );

    fearless_simd::kernel!(
        #[inline]
        fn eight(avx2: Avx2, sum: Eight, x: Eight, w: Eight) -> Eight {
            _mm256_add_epi32(sum.into(), _mm256_madd_epi16(x.into(), w.into())).simd_into(avx2)
        }
    );

    impl super::Pairs for Avx512 {
        const WHOLE_PANELS: bool = true;

        #[inline(always)]
        fn add_products(self, sum: Sixteen, x: Sixteen, w: Sixteen) -> Sixteen {
            sixteen(self, sum, x, w)
        }
    }

    impl super::Pairs for Avx2 {
        const WHOLE_PANELS: bool = false;

        #[inline(always)]
        fn add_products(self, sum: Eight, x: Eight, w: Eight) -> Eight {
            eight(self, sum, x, w)
        }
    }
}

/// Points that stay in the first-level cache while all outputs are computed: a multiple of two
/// registers.
const BLOCK: usize = 64;

/// Whether a layer can be evaluated in whole numbers: weights of less than 14 bits, and a row for
/// the units of packed points.
pub(super) fn suit(layer: &Dense<'_>) -> bool {
    layer.weight.dtype() == DType::F16 && layer.weight.rows() > 1
}

/// As [`dense`](super::dense), but for rounding; `x` is overwritten. A point with a value that
/// is not finite gives no finite numbers.
#[expect(clippy::too_many_arguments, reason = "as for `dense`")]
pub(super) fn dense<S: Pairs>(
    simd: S,
    layer: &Dense<'_>,
    x: &mut [f32],
    y: &mut [f32],
    n: usize,
    stride: usize,
    relu: bool,
    panel: &mut [f32],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (n_in, n_out) = (layer.weight.rows(), layer.weight.cols());
            let n_pairs = n_in.div_ceil(2);
            let x = &mut x[..n_in * stride];
            pack_points(simd, x, n, stride);
            let (pairs, rest) = x.split_at_mut(n_pairs * stride);
            let (units, free) = rest.split_at_mut(stride);
            let points = Points { pairs, units, stride };
            let panel = panel[..panel_len(n_in)].as_chunks_mut::<PANEL>().0;
            let width = |first: usize| PANEL.min(n_out - first);
            let firsts = (0..n_out).step_by(PANEL);
            // Where points have been there is room for all weights, if points are many.
            let free = free.as_chunks_mut::<PANEL>().0;
            if free.len() < firsts.len() * (n_pairs + 2) {
                for first in firsts {
                    let [units, bias] = pack_panel(simd, layer, first, panel);
                    let weights = &panel[..n_pairs];
                    let outputs = Outputs { weights, units, bias, width: width(first), relu };
                    multiply_panel(simd, &outputs, &points, &mut y[first * stride..], 0..n);
                }
                return;
            }
            for (first, place) in firsts.clone().zip(free.chunks_exact_mut(n_pairs + 2)) {
                let rest = pack_panel(simd, layer, first, panel);
                place[..n_pairs].copy_from_slice(&panel[..n_pairs]);
                place[n_pairs..].copy_from_slice(&rest);
            }
            for block in (0..n).step_by(BLOCK) {
                let at = block..n.min(block + BLOCK);
                for (first, place) in firsts.clone().zip(free.chunks_exact(n_pairs + 2)) {
                    let (weights, rest) = place.split_at(n_pairs);
                    let (units, bias, width) = (rest[0], rest[1], width(first));
                    let outputs = Outputs { weights, units, bias, width, relu };
                    let y = &mut y[first * stride..];
                    multiply_panel(simd, &outputs, &points, y, at.clone());
                }
            }
        },
    );
}

/// A panel's outputs.
struct Outputs<'o> {
    /// `[pairs of inputs][PANEL]`.
    weights: &'o [[f32; PANEL]],
    /// What a weight of 1 stands for.
    units: [f32; PANEL],
    bias: [f32; PANEL],
    /// Outputs that there are.
    width: usize,
    relu: bool,
}

/// Packed points.
struct Points<'p> {
    /// `[pairs of inputs][stride]`.
    pairs: &'p [f32],
    /// What a value of 1 stands for: one a point.
    units: &'p [f32],
    stride: usize,
}

/// Rounds `n` points, `[n_in][stride]`, in place to pairs, and writes to the row behind them
/// what a unit of each point is.
#[inline(always)]
fn pack_points<S: Simd>(simd: S, x: &mut [f32], n: usize, stride: usize) {
    let lanes = S::f32s::LEN;
    let splat = |v: f32| S::f32s::splat(simd, v);
    let (n_in, magnitude) = (x.len() / stride, S::i32s::splat(simd, i32::MAX));
    for at in (0..n).step_by(lanes) {
        // As whole numbers, of which infinity and NaN are the largest.
        let mut most: S::i32s = splat(LEAST * MOST).bitcast();
        for row in x.chunks_exact(stride) {
            let bits: S::i32s = S::f32s::from_slice(simd, &row[at..at + lanes]).bitcast();
            most = most.max(bits & magnitude);
        }
        let unit = most.bitcast::<S::f32s>() * (1.0 / MOST);
        let units = splat(1.0) / unit;
        let rounded = |x: &[f32], row: usize| -> S::i32s {
            let value = S::f32s::from_slice(simd, &x[row * stride + at..][..lanes]);
            value.mul_add(units, splat(WHOLE)).bitcast()
        };
        for pair in 0..n_in.div_ceil(2) {
            let low = rounded(x, 2 * pair) & 0xffff;
            let both =
                if 2 * pair + 1 < n_in { low | (rounded(x, 2 * pair + 1) << 16) } else { low };
            both.bitcast::<S::f32s>().store_slice(&mut x[pair * stride + at..][..lanes]);
        }
        unit.store_slice(&mut x[n_in.div_ceil(2) * stride + at..][..lanes]);
    }
}

/// Decodes the panel of outputs from `first` on, `[n_in][PANEL]`, and rounds it in place to pairs
/// of inputs. Gives the outputs' units and biases.
#[inline(always)]
fn pack_panel<S: Simd>(
    simd: S,
    layer: &Dense<'_>,
    first: usize,
    rows: &mut [[f32; PANEL]],
) -> [[f32; PANEL]; 2] {
    let width = PANEL.min(layer.weight.cols() - first);
    load_panel::<S, F16>(simd, &layer.weight, (first, width), rows.as_flattened_mut());
    let splat = |v: f32| f32x8::splat(simd, v);
    let (mut most, mut sum) = (splat(0.0), splat(0.0));
    for row in rows.iter() {
        let magnitude = f32x8::load_array(simd, *row).abs();
        (most, sum) = (most.max(magnitude), sum + magnitude);
    }
    let unit = (sum * (1.0 / MOST_SUM)).max(most * (1.0 / MOST_WEIGHT)).max(splat(LEAST));
    let units = splat(1.0) / unit;
    for pair in 0..rows.len().div_ceil(2) {
        let rounded = |row: &[f32; PANEL]| -> i32x8<S> {
            f32x8::load_array(simd, *row).mul_add(units, splat(WHOLE)).bitcast()
        };
        let high = rows.get(2 * pair + 1).unwrap_or(&[0.0; PANEL]);
        let both = (rounded(&rows[2 * pair]) & 0xffff) | (rounded(high) << 16);
        both.bitcast::<f32x8<S>>().store_array(&mut rows[pair]);
    }
    [unit.into(), load_bias::<F16>(layer, first, width)]
}

/// The outputs of a panel at some points.
#[inline(always)]
fn multiply_panel<S: Pairs>(
    simd: S,
    outputs: &Outputs<'_>,
    points: &Points<'_>,
    y: &mut [f32],
    at: Range<usize>,
) {
    let two = at.end - at.len() % (2 * S::i32s::LEN);
    if S::WHOLE_PANELS {
        multiply::<S, 0, PANEL, 2>(simd, outputs, points, y, at.start..two);
    } else {
        multiply::<S, 0, HALF, 2>(simd, outputs, points, y, at.start..two);
        multiply::<S, HALF, HALF, 2>(simd, outputs, points, y, at.start..two);
    }
    multiply::<S, 0, PANEL, 1>(simd, outputs, points, y, two..at.end);
}

/// The `O` outputs from `FROM` on of a panel, as far as there are any, at `V` registers of
/// points at a time.
#[inline(always)]
fn multiply<S: Pairs, const FROM: usize, const O: usize, const V: usize>(
    simd: S,
    outputs: &Outputs<'_>,
    points: &Points<'_>,
    y: &mut [f32],
    at: Range<usize>,
) {
    let lanes = S::i32s::LEN;
    for at in at.step_by(V * lanes) {
        let mut sums = [[S::i32s::splat(simd, 0); V]; O];
        for (weights, row) in outputs.weights.iter().zip(points.pairs.chunks_exact(points.stride)) {
            let row = &row[at..at + V * lanes];
            let mut values = [S::i32s::splat(simd, 0); V];
            for (v, value) in values.iter_mut().enumerate() {
                *value = S::f32s::from_slice(simd, &row[v * lanes..][..lanes]).bitcast();
            }
            for (sums, weight) in sums.iter_mut().zip(&weights[FROM..]) {
                let weight = S::i32s::splat(simd, weight.to_bits().cast_signed());
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum = simd.add_products(*sum, value, weight);
                }
            }
        }
        let mut units = [S::f32s::splat(simd, 0.0); V];
        for (v, unit) in units.iter_mut().enumerate() {
            *unit = S::f32s::from_slice(simd, &points.units[at + v * lanes..][..lanes]);
        }
        // A whole panel's loop is unrolled, so that sums stay in registers.
        for (o, sums) in sums.iter().enumerate() {
            if FROM + o < outputs.width {
                let bias = S::f32s::splat(simd, outputs.bias[FROM + o]);
                let mut values = [bias; V];
                for ((value, sum), unit) in values.iter_mut().zip(sums).zip(units) {
                    let unit = unit * outputs.units[FROM + o];
                    *value = sum.to_float::<S::f32s>().mul_add(unit, bias);
                }
                let row = &mut y[(FROM + o) * points.stride + at..][..V * lanes];
                finish_row(simd, &values, row, outputs.relu);
            }
        }
    }
}

#[cfg(test)]
mod tests;
