//! The paper's positional encoding (Mildenhall et al. 2020, equation 4).

use fearless_simd::{Simd, SimdBase, SimdFloat};

use crate::{Error, lanes};

/// Sines and cosines of octaves of a position.
///
/// A point x (unit coordinates, centred: `2 u - 1`) becomes, for
/// k = 0 .. `n_frequencies`, `sin(2^k π x)` over x, y, z, then `cos(2^k π x)`
/// over x, y, z; before these the three coordinates themselves when
/// `include_input`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrequencyConfig {
    /// Octaves, 1 to 16.
    pub n_frequencies: u32,
    /// Whether x itself stands before the sines.
    pub include_input: bool,
}

impl FrequencyConfig {
    /// Values that the encoding gives for a point.
    #[must_use]
    pub const fn n_output(&self) -> usize {
        (6 * self.n_frequencies + if self.include_input { 3 } else { 0 }) as usize
    }

    /// Checks the number of octaves.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub const fn validate(&self) -> Result<(), Error> {
        if self.n_frequencies == 0 || self.n_frequencies > 16 {
            return Err(Error::Range("frequency encoding n_frequencies"));
        }
        Ok(())
    }
}

/// Encodes unit points: writes `n_output` rows, `stride` values apart.
/// A multiple of 16 points.
#[inline(always)]
pub fn encode<S: Simd>(
    simd: S,
    config: FrequencyConfig,
    points: [&[f32]; 3],
    out: &mut [f32],
    stride: usize,
) {
    let n = S::f32s::LEN;
    let two = S::f32s::splat(simd, 2.0);
    for (axis, coordinates) in points.iter().enumerate() {
        for (g, u) in coordinates.chunks_exact(n).enumerate() {
            let x = S::f32s::from_slice(simd, u).mul_sub(two, S::f32s::splat(simd, 1.0));
            let mut row = axis;
            let mut write = |value: S::f32s| {
                value.store_slice(&mut out[row * stride + g * n..][..n]);
                row += 3;
            };
            if config.include_input {
                write(x);
            }
            let mut phase = x;
            for _ in 0..config.n_frequencies {
                write(lanes::sin_pi(simd, phase));
                write(lanes::sin_pi(simd, phase + 0.5));
                phase *= two;
            }
        }
    }
}
