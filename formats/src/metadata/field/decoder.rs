//! The networks of a kind of field that has a decoder: the end of its FIELD, and their
//! tensors.

use pocketnerf_core::TensorView;
use pocketnerf_core::field::{Decoder, Shading};
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};
use serde::{Deserialize, Serialize};

use super::widths::Widths;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, TensorName};

/// Codes of the tensors: weight and bias of the density network's layers, then of the colour
/// network's.
const DENSITY: [u8; 2] = [1, 2];
const COLOR: [u8; 2] = [3, 4];
/// The names of the tensors.
pub(crate) const NAMES: [Known; 4] = [
    Known::layers(DENSITY[0], "density weight"),
    Known::layers(DENSITY[1], "density bias"),
    Known::layers(COLOR[0], "colour weight"),
    Known::layers(COLOR[1], "colour bias"),
];
/// The most tensors that a decoder has.
pub(crate) const MAX_TENSORS: usize = 4 * MAX_LAYERS;

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
pub(crate) struct Metadata {
    pub(crate) n_features: u32,
    pub(crate) sh_degree: u32,
    pub(crate) shading: Shading,
    pub(crate) log_density_bias: f32,
    pub(crate) density: Widths,
    pub(crate) color: Widths,
}

/// Reads the end of FIELD.
pub(crate) fn read(mut fields: Fields<'_>) -> Result<Metadata, FormatError> {
    let decoder: DecoderV1 = fields.take()?;
    fields.finite("log_density_bias", &[decoder.log_density_bias])?;
    let shading = match decoder.shading {
        PER_SAMPLE => Shading::PerSample,
        PER_RAY => Shading::PerRay,
        code => return Err(fields.unknown("shading", code)),
    };
    fields.finish()?;
    let DecoderV1 { n_features, sh_degree, log_density_bias, density, color, .. } = decoder;
    Ok(Metadata { n_features, sh_degree, shading, log_density_bias, density, color })
}

/// Appends the end of FIELD.
pub(crate) fn write<W: Extend<u8>>(metadata: &Metadata, bytes: W) -> Option<W> {
    let Metadata { n_features, sh_degree, shading, log_density_bias, density, color } = *metadata;
    let shading = match shading {
        Shading::PerSample => PER_SAMPLE,
        Shading::PerRay => PER_RAY,
    };
    append(bytes, &DecoderV1 { n_features, sh_degree, shading, log_density_bias, density, color })
}

/// What FIELD says of a decoder; `None` for networks that it cannot describe.
pub(crate) fn metadata(decoder: &Decoder<'_>) -> Option<Metadata> {
    Some(Metadata {
        n_features: decoder.n_features,
        sh_degree: decoder.sh_degree,
        shading: decoder.shading,
        log_density_bias: decoder.log_density_bias,
        density: Widths::of(decoder.density.layers())?,
        color: Widths::of(decoder.color.layers())?,
    })
}

/// Takes the tensors of the decoder that FIELD describes.
pub(crate) fn open<'a>(
    metadata: &Metadata,
    listed: &mut Listed<'a>,
) -> Result<Decoder<'a>, FormatError> {
    Ok(Decoder {
        density: network(&metadata.density, DENSITY, listed)?,
        color: network(&metadata.color, COLOR, listed)?,
        n_features: metadata.n_features,
        sh_degree: metadata.sh_degree,
        shading: metadata.shading,
        log_density_bias: metadata.log_density_bias,
    })
}

/// A network of the stated widths.
fn network<'a>(
    widths: &Widths,
    codes: [u8; 2],
    listed: &mut Listed<'a>,
) -> Result<Mlp<'a>, FormatError> {
    let mut layers = [Dense::EMPTY; MAX_LAYERS];
    let mut n_layers = 0;
    while let Some(shape) = widths.layer(n_layers) {
        let names = codes.map(|code| TensorName::new(code, n_layers as u32));
        layers[n_layers] = listed.layer(names, shape)?;
        n_layers += 1;
    }
    Ok(Mlp::new(&layers[..n_layers])?)
}

/// The weights with their names, in the order of the file.
pub(crate) fn tensors<'f, 'a>(
    decoder: &'f Decoder<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    layers(&decoder.density, DENSITY).chain(layers(&decoder.color, COLOR))
}

fn layers<'f, 'a>(
    network: &'f Mlp<'a>,
    [weight, bias]: [u8; 2],
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    (0..).zip(network.layers()).flat_map(move |(i, layer)| {
        let bias = layer.bias.map(|view| (TensorName::new(bias, i), view));
        core::iter::once((TensorName::new(weight, i), layer.weight)).chain(bias)
    })
}
