//! The paper's positional encoding, octave by octave.

use super::math::sin_cos_pi;
use super::network::{MAX_WIDTH, Values};
use crate::encoding::FrequencyConfig;

/// Encodes unit point `u`; the order of the values is that of [`FrequencyConfig`].
///
/// `2 u - 1` and its octaves are exact in f64, so each value is within 1e-15 of
/// the sine or cosine of the f32 point.
pub(super) fn encode(config: &FrequencyConfig, u: [f32; 3]) -> Values {
    let x = u.map(|v| 2.0 * f64::from(v) - 1.0);
    let mut out = [0.0; MAX_WIDTH];
    let mut at = 0;
    if config.include_input {
        out[..3].copy_from_slice(&x);
        at = 3;
    }
    for k in 0..config.n_frequencies {
        for axis in 0..3 {
            let (sin, cos) = sin_cos_pi(f64::from(1u32 << k) * x[axis]);
            out[at + axis] = sin;
            out[at + 3 + axis] = cos;
        }
        at += 6;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that the encoding starts with `expected` and is 0 beyond it.
    fn assert_encodes(include_input: bool, u: [f32; 3], expected: &[f64]) {
        let config = FrequencyConfig { n_frequencies: 2, include_input };
        assert_eq!(config.n_output(), expected.len());
        let out = encode(&config, u);
        for (i, value) in out.iter().enumerate() {
            let hand = expected.get(i).copied().unwrap_or(0.0);
            assert!((value - hand).abs() < 1e-15, "value {i}: {value}, by hand {hand}");
        }
    }

    #[test]
    fn a_point_by_hand() {
        // u = (0.75, 0.5, 0.0) is x = (1/2, 0, -1): π x is 90°, 0° and -180°, 2 π x twice that.
        let octaves = [
            [1.0, 0.0, 0.0], // sin π x
            [0.0, 1.0, -1.0],
            [0.0, 0.0, 0.0], // sin 2 π x
            [-1.0, 1.0, 1.0],
        ];
        let u = [0.75, 0.5, 0.0];
        assert_encodes(false, u, octaves.as_flattened());
        let mut with_input = [0.0; 15];
        with_input[..3].copy_from_slice(&[0.5, 0.0, -1.0]);
        with_input[3..].copy_from_slice(octaves.as_flattened());
        assert_encodes(true, u, &with_input);
    }

    #[test]
    fn an_eighth_of_a_turn() {
        // u = 0.625 is x = 1/4: sin 45° = cos 45°; the second octave is 90°.
        let h = core::f64::consts::FRAC_1_SQRT_2;
        let (a, b) = ([h; 6], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        assert_encodes(false, [0.625; 3], [a, b].as_flattened());
    }
}
