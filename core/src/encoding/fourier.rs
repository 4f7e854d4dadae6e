//! Fourier features: a position or a direction as sines and cosines. Octaves as in the
//! paper (Mildenhall et al. 2020, equation 4), or frequencies drawn at random (Tancik
//! et al. 2020, section 3).

use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat};

use crate::network::blocks::{BLOCK, Row};
use crate::store::{F16, F32, Store};
use crate::{DType, Error, TensorView, lanes};

/// Most octaves.
pub const MAX_OCTAVES: u32 = 16;
/// Most random frequencies.
pub const MAX_FREQUENCIES: usize = 512;

/// 1 / π in two parts: twelve bits, and the rest to 1e-12.
const INVERSE_PI: [f32; 2] = [0.318_237_3, 7.258_15e-5];
/// The upper twelve bits of a number's fraction: two such numbers have an exact product.
const UPPER: i32 = -0x1000;

/// Which waves.
#[derive(Clone, Copy, Debug)]
pub enum Waves<'a> {
    /// For k = 0 .. `n`: `sin(2^k x)` over the three coordinates, then `cos(2^k x)`;
    /// `sin(2^k π x)` and `cos(2^k π x)` where `pi`, as the paper has it (its authors'
    /// program is without π). At most 16; none is no encoding.
    Octaves {
        /// Octaves.
        n: u32,
        /// Whether phases have the factor π.
        pi: bool,
    },
    /// `[3, n]` frequencies B, waves a unit: `cos(2π x B)` for all n, then
    /// `sin(2π x B)`. At most 512.
    Gaussian(TensorView<'a>),
}

/// Fourier features of a point x, the coordinates themselves first where
/// `include_input`.
///
/// Phases are pairs of f32, reduced to a turn before the wave is looked up, so that
/// for |x| ≤ 4 a value is within 1e-6 of the sine or cosine of the f32 coordinates up to
/// k = 12, and within 5e-6 up to k = 15. With random frequencies, phases are f32:
/// within 1e-6 + 4e-7 times the largest product in the phase.
#[derive(Clone, Copy, Debug)]
pub struct Fourier<'a> {
    /// The waves.
    pub waves: Waves<'a>,
    /// Whether x itself stands before them.
    pub include_input: bool,
}

impl Fourier<'_> {
    /// Values of an encoded point.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        let waves = match &self.waves {
            Waves::Octaves { n, .. } => 6 * *n as usize,
            Waves::Gaussian(matrix) => 2 * matrix.cols(),
        };
        waves + if self.include_input { 3 } else { 0 }
    }

    /// Checks the number of waves.
    ///
    /// # Errors
    /// [`Error::Range`] or [`Error::Shape`].
    pub fn validate(&self) -> Result<(), Error> {
        match &self.waves {
            Waves::Octaves { n, .. } if *n > MAX_OCTAVES => {
                return Err(Error::Range("Fourier features: octaves"));
            }
            Waves::Gaussian(matrix) => {
                if matrix.rows() != 3 || matches!(matrix.dtype(), DType::I8 | DType::U16) {
                    return Err(Error::Shape("Fourier features: the frequencies"));
                }
                if !(1..=MAX_FREQUENCIES).contains(&matrix.cols()) {
                    return Err(Error::Range("Fourier features: frequencies"));
                }
            }
            Waves::Octaves { .. } => {}
        }
        if self.n_output() == 0 {
            return Err(Error::Range("Fourier features: nothing encoded"));
        }
        Ok(())
    }

    /// Encodes points `x`, whose number is a multiple of 16: block after block,
    /// [`n_output`](Self::n_output) rows each. What fills up the last block is
    /// encoded as 0.
    #[inline(always)]
    pub fn encode<S: Simd>(&self, simd: S, x: [&[f32]; 3], map: Affine, out: &mut [Row]) {
        let (n, len) = (S::f32s::LEN, x[0].len());
        let n_output = self.n_output();
        for (b, rows) in out.chunks_exact_mut(n_output).enumerate() {
            for at in (0..BLOCK).step_by(n) {
                let first = b * BLOCK + at;
                if first >= len {
                    rows.iter_mut().for_each(|row| row[at..at + n].fill(0.0));
                    continue;
                }
                let load = |a: usize| {
                    let u = S::f32s::from_slice(simd, &x[a][first..first + n]);
                    u * map.scale[a] + map.offset[a]
                };
                self.encode_register(simd, [load(0), load(1), load(2)], rows, at);
            }
        }
    }

    #[inline(always)]
    fn encode_register<S: Simd>(&self, simd: S, x: [S::f32s; 3], rows: &mut [Row], at: usize) {
        let lanes = at..at + S::f32s::LEN;
        let mut row = 0;
        if self.include_input {
            for (to, x) in rows.iter_mut().zip(x) {
                x.store_slice(&mut to[lanes.clone()]);
            }
            row = 3;
        }
        match &self.waves {
            Waves::Octaves { n, pi } => {
                for (a, x) in x.into_iter().enumerate() {
                    let [mut high, mut low] = half_turns(simd, x, *pi);
                    for k in 0..*n as usize {
                        // Whole half turns of the high part alone decide the sign;
                        // what is left is exact.
                        let [sin, cos] = waves(simd, high, low);
                        let at = row + 6 * k + a;
                        sin.store_slice(&mut rows[at][lanes.clone()]);
                        cos.store_slice(&mut rows[at + 3][lanes.clone()]);
                        (high, low) = (high * 2.0, low * 2.0);
                    }
                }
            }
            Waves::Gaussian(matrix) => match matrix.dtype() {
                DType::F32 => gaussian::<S, F32>(simd, matrix, x, &mut rows[row..], at),
                DType::F16 | DType::I8 | DType::U16 => {
                    gaussian::<S, F16>(simd, matrix, x, &mut rows[row..], at);
                }
            },
        }
    }
}

/// An affine map, axis by axis: `x = scale u + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Factors.
    pub scale: [f32; 3],
    /// Summands.
    pub offset: [f32; 3],
}

impl Affine {
    /// Nothing changes.
    pub const IDENTITY: Self = Self { scale: [1.0; 3], offset: [0.0; 3] };
    /// From the unit cube to -1 .. 1.
    pub const CENTRED: Self = Self { scale: [2.0; 3], offset: [-1.0; 3] };
}

/// The phase of x radians in half turns, in two parts; of `π x` radians, exactly,
/// where `pi`.
#[inline(always)]
fn half_turns<S: Simd>(simd: S, x: S::f32s, pi: bool) -> [S::f32s; 2] {
    let zero = S::f32s::splat(simd, 0.0);
    if pi {
        return [x, zero];
    }
    let upper: S::f32s = (x.bitcast::<S::i32s>() & S::i32s::splat(simd, UPPER)).bitcast();
    let low = (x - upper) * INVERSE_PI[0] + x * INVERSE_PI[1];
    [upper * INVERSE_PI[0], low]
}

/// Sine and cosine of `π (high + low)`.
#[inline(always)]
fn waves<S: Simd>(simd: S, high: S::f32s, low: S::f32s) -> [S::f32s; 2] {
    let whole = (high * 0.5).round_ties_even() * 2.0;
    let rest = (high - whole) + low;
    [lanes::sin_pi(simd, rest), lanes::sin_pi(simd, rest + 0.5)]
}

#[inline(always)]
fn gaussian<S: Simd, T: Store>(
    simd: S,
    matrix: &TensorView<'_>,
    x: [S::f32s; 3],
    rows: &mut [Row],
    at: usize,
) {
    let n = matrix.cols();
    let values = T::values(matrix.bytes());
    let (cosines, sines) = rows.split_at_mut(n);
    for (f, (cosine, sine)) in cosines.iter_mut().zip(sines).enumerate() {
        let frequency =
            |a: usize| S::f32s::splat(simd, T::decode(values[a * n + f]) * matrix.scale());
        let turns = x[2].mul_add(frequency(2), x[1].mul_add(frequency(1), x[0] * frequency(0)));
        let [sin, cos] = waves(simd, turns * 2.0, S::f32s::splat(simd, 0.0));
        cos.store_slice(&mut cosine[at..at + S::f32s::LEN]);
        sin.store_slice(&mut sine[at..at + S::f32s::LEN]);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use fearless_simd::dispatch;
    use std::vec;
    use std::vec::Vec;

    /// All values of the points `x`, point after point, at every SIMD level.
    fn encoded(encoding: Fourier<'_>, x: &[[f32; 3]]) -> Vec<Vec<Vec<f32>>> {
        let padded = x.len().next_multiple_of(16);
        let axes = [0, 1, 2].map(|a| {
            let mut axis: Vec<f32> = x.iter().map(|x| x[a]).collect();
            axis.resize(padded, 0.0);
            axis
        });
        let axes = [0, 1, 2].map(|a| &axes[a][..]);
        let levels = crate::SimdLevel::ALL.into_iter().filter_map(|l| l.token().ok());
        let n = encoding.n_output();
        let at_level = |level| {
            let mut out = vec![[f32::NAN; BLOCK]; padded.div_ceil(BLOCK) * n];
            dispatch!(level, simd => encoding.encode(simd, axes, Affine::IDENTITY, &mut out));
            assert!(out.iter().flatten().all(|v| v.is_finite()));
            let value = |p: usize, row: usize| out[p / BLOCK * n + row][p % BLOCK];
            (0..x.len()).map(|p| (0..n).map(|row| value(p, row)).collect()).collect()
        };
        levels.map(at_level).collect()
    }

    #[test]
    fn octaves_within_the_stated_error() {
        let x: Vec<[f32; 3]> =
            (0..400).map(|i| [-4.0 + 0.02 * i as f32, 0.013 * i as f32 - 1.3, 1.0]).collect();
        for pi in [false, true] {
            let waves = Waves::Octaves { n: 16, pi };
            let encoding = Fourier { waves, include_input: true };
            let factor = if pi { core::f64::consts::PI } else { 1.0 };
            for level in encoded(encoding, &x) {
                for (values, x) in level.iter().zip(&x) {
                    assert_eq!(values[..3], x[..]);
                    for (k, octave) in values[3..].chunks(6).enumerate() {
                        for a in 0..3 {
                            let phase = factor * f64::from(1 << k) * f64::from(x[a]);
                            let [sin, cos] = [octave[a], octave[3 + a]].map(f64::from);
                            let bound = if k <= 12 { 1e-6 } else { 5e-6 };
                            assert!((sin - phase.sin()).abs() < bound, "{k} {x:?} {sin}");
                            assert!((cos - phase.cos()).abs() < bound, "{k} {x:?} {cos}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn random_frequencies_by_hand() {
        // B is [[1, 0], [0, 1/2], [0, 1/4]]: phases 2π x and π y + π z / 2.
        let matrix: Vec<u8> =
            [1.0f32, 0.0, 0.0, 0.5, 0.0, 0.25].iter().flat_map(|v| v.to_le_bytes()).collect();
        let matrix =
            TensorView::new(&matrix, DType::F32, [3, 2], 0, crate::Layout::RowMajor).unwrap();
        let encoding = Fourier { waves: Waves::Gaussian(matrix), include_input: false };
        assert_eq!(encoding.n_output(), 4);
        for level in encoded(encoding, &[[0.25, 0.5, 1.0], [0.5, 0.0, 1.0]]) {
            // A quarter turn and a half one; a half turn and a quarter.
            let expected = [[0.0, -1.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 1.0]];
            for (found, expected) in level.iter().flatten().zip(expected.as_flattened()) {
                assert!((found - expected).abs() < 1e-6, "{level:?}");
            }
        }
    }
}
