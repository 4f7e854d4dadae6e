//! What lies behind an encoding: densities and channels of encoded values.

use super::shade;
use crate::field::{Decoder, Features, MAX_CHANNELS, Shading};
use crate::reference::math::exp;
use crate::reference::network::{self, Values};

/// Highest log density; beyond it sigma stays at e^15 per scene unit.
const MAX_LOG_DENSITY: f64 = 15.0;

/// Sigma and channels of encoded values behind a decoder.
pub(crate) fn decode(
    decoder: &Decoder<'_>,
    encoded: &Values,
    direction: [f32; 3],
) -> (f64, Features) {
    let (sigma, features) = density(decoder, encoded);
    if decoder.shading == Shading::PerRay {
        return (sigma, features);
    }
    let mut channels = [0.0; MAX_CHANNELS];
    channels[..3].copy_from_slice(&shade(decoder, &features, direction));
    (sigma, channels)
}

/// Sigma, per scene unit, and the features of an encoded point.
///
/// `sigma = exp(min(raw + log_density_bias, 15))`; a NaN is empty space.
fn density(decoder: &Decoder<'_>, encoded: &Values) -> (f64, Features) {
    let out = network::forward(&decoder.density, encoded);
    let log_density = out[0] + f64::from(decoder.log_density_bias);
    let sigma = if log_density.is_nan() { 0.0 } else { exp(log_density.min(MAX_LOG_DENSITY)) };
    let mut features = [0.0; MAX_CHANNELS];
    let n = decoder.n_features as usize;
    features[..n].copy_from_slice(&out[1..=n]);
    (sigma, features)
}
