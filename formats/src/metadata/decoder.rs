//! The end of FIELD of a kind that has a decoder.

use pocketnerf_core::field::Shading;
use serde::{Deserialize, Serialize};

use super::Fields;
use super::widths::Widths;
use crate::FormatError;

/// Codes of [`Shading`].
const PER_SAMPLE: u8 = 0;
const PER_RAY: u8 = 1;

/// The end of FIELD.
#[derive(Serialize, Deserialize)]
pub(crate) struct DecoderV1 {
    n_features: u32,
    sh_degree: u32,
    shading: u8,
    log_density_bias: f32,
    density: Widths,
    color: Widths,
}

/// What FIELD says of the decoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DecoderConfig {
    pub(crate) n_features: u32,
    pub(crate) sh_degree: u32,
    pub(crate) shading: Shading,
    pub(crate) log_density_bias: f32,
    pub(crate) density: Widths,
    pub(crate) color: Widths,
}

/// Reads the end of FIELD.
pub(crate) fn read_decoder(mut fields: Fields<'_>) -> Result<DecoderConfig, FormatError> {
    let decoder: DecoderV1 = fields.take()?;
    fields.finite("log_density_bias", &[decoder.log_density_bias])?;
    let shading = match decoder.shading {
        PER_SAMPLE => Shading::PerSample,
        PER_RAY => Shading::PerRay,
        code => return Err(fields.unknown("shading", code)),
    };
    fields.finish()?;
    let DecoderV1 { n_features, sh_degree, log_density_bias, density, color, .. } = decoder;
    Ok(DecoderConfig { n_features, sh_degree, shading, log_density_bias, density, color })
}

#[cfg(feature = "alloc")]
impl DecoderV1 {
    pub(crate) fn of(decoder: &DecoderConfig) -> Self {
        Self {
            n_features: decoder.n_features,
            sh_degree: decoder.sh_degree,
            shading: match decoder.shading {
                Shading::PerSample => PER_SAMPLE,
                Shading::PerRay => PER_RAY,
            },
            log_density_bias: decoder.log_density_bias,
            density: decoder.density,
            color: decoder.color,
        }
    }
}
