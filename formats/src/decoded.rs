//! The tensors of a field that is an encoding and a decoder.

#[cfg(feature = "hash-grid")]
use pocketnerf_core::encoding::MAX_LEVELS;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};
use pocketnerf_core::{AnyField, TensorView};

use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::decoder::DecoderConfig;
use crate::metadata::widths::Widths;
use crate::tensors::TensorName;

/// The weights of a field of such a kind with their names, in the order of the file.
pub(crate) fn tensors<'f, 'a>(
    field: &'f AnyField<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    parts(field).into_iter().flat_map(|(grid, decoder)| {
        let grid = (0..).zip(grid).map(|(l, table)| (TensorName::GridLevel(l), *table));
        let density = layers(&decoder.density, TensorName::DensityWeight, TensorName::DensityBias);
        let color = layers(&decoder.color, TensorName::ColorWeight, TensorName::ColorBias);
        grid.chain(density).chain(color)
    })
}

/// Grid levels and decoder of a field; `None` for a kind without a decoder.
fn parts<'f, 'a>(field: &'f AnyField<'a>) -> Option<(&'f [TensorView<'a>], &'f Decoder<'a>)> {
    match field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => {
            let n_levels = (field.grid.config.n_levels as usize).min(MAX_LEVELS);
            Some((&field.grid.levels[..n_levels], &field.decoder))
        }
        _ => None,
    }
}

fn layers<'f, 'a>(
    network: &'f Mlp<'a>,
    weight: fn(u32) -> TensorName,
    bias: fn(u32) -> TensorName,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    (0..).zip(network.layers()).flat_map(move |(i, layer)| {
        let bias = layer.bias.map(|view| (bias(i), view));
        core::iter::once((weight(i), layer.weight)).chain(bias)
    })
}

/// The tables of a grid of so many levels.
#[cfg(feature = "hash-grid")]
#[inline(never)]
pub(crate) fn levels<'a>(
    n_levels: u32,
    listed: &mut Listed<'a>,
) -> Result<[TensorView<'a>; MAX_LEVELS], FormatError> {
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    for (l, level) in (0..n_levels).zip(&mut levels) {
        *level = listed.need(TensorName::GridLevel(l))?;
    }
    Ok(levels)
}

/// The decoder that FIELD describes.
pub(crate) fn decoder<'a>(
    config: &DecoderConfig,
    listed: &mut Listed<'a>,
) -> Result<Decoder<'a>, FormatError> {
    let names = (TensorName::DensityWeight as Name, TensorName::DensityBias as Name);
    let density = network(&config.density, names, listed)?;
    let names = (TensorName::ColorWeight as Name, TensorName::ColorBias as Name);
    let color = network(&config.color, names, listed)?;
    Ok(Decoder {
        density,
        color,
        n_features: config.n_features,
        sh_degree: config.sh_degree,
        shading: config.shading,
        log_density_bias: config.log_density_bias,
    })
}

/// What the tensor of a layer is called.
type Name = fn(u32) -> TensorName;

/// A network of the stated widths.
fn network<'a>(
    widths: &Widths,
    (weight, bias): (Name, Name),
    listed: &mut Listed<'a>,
) -> Result<Mlp<'a>, FormatError> {
    let mut layers = [Dense::EMPTY; MAX_LAYERS];
    let mut n_layers = 0;
    while let Some(shape) = widths.layer(n_layers) {
        let i = n_layers as u32;
        layers[n_layers] = listed.layer(weight(i), bias(i), shape)?;
        n_layers += 1;
    }
    Ok(Mlp::new(&layers[..n_layers])?)
}
