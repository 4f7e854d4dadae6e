//! The tensors of the paper's field.

use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};
use pocketnerf_core::{AnyField, TensorView};

use crate::FormatError;
use crate::directory::{Listed, expect_shape};
use crate::metadata::nerf::{FeatureV1, FourierV1, NerfV1, NetworkV1};
use crate::tensors::{LayerName, Network, TensorName};

/// The field that FIELD describes.
pub(crate) fn read<'a>(
    config: &NerfV1,
    listed: &mut Listed<'a>,
) -> Result<NerfField<'a>, FormatError> {
    let positions = fourier(&config.positions, TensorName::PositionFrequencies, listed)?;
    let directions = match &config.directions {
        Some(encoding) => Some(fourier(encoding, TensorName::DirectionFrequencies, listed)?),
        None => None,
    };
    let fine = network(&config.fine, Network::Fine, listed)?;
    let coarse = match &config.coarse {
        Some(config) => Some(network(config, Network::Coarse, listed)?),
        None => None,
    };
    Ok(NerfField {
        positions,
        directions,
        map: Affine { scale: config.scale, offset: config.offset },
        activation: config.activation(),
        density_scale: config.density_scale,
        fine,
        coarse,
    })
}

fn fourier<'a>(
    config: &FourierV1,
    name: TensorName,
    listed: &mut Listed<'a>,
) -> Result<Fourier<'a>, FormatError> {
    let waves = if config.is_gaussian() {
        let matrix = listed.need(name)?;
        expect_shape(name, &matrix, [3, config.n])?;
        Waves::Gaussian(matrix)
    } else {
        Waves::Octaves { n: config.n, pi: config.pi }
    };
    Ok(Fourier { waves, include_input: config.include_input })
}

fn network<'a>(
    config: &NetworkV1,
    which: Network,
    listed: &mut Listed<'a>,
) -> Result<NerfNetwork<'a>, FormatError> {
    let mut layer = |name: LayerName, shape: [u32; 2]| {
        let (weight, bias) = (TensorName::LayerWeight, TensorName::LayerBias);
        listed.layer(weight(which, name), bias(which, name), shape)
    };
    let (mut trunk, mut depth) = ([Dense::EMPTY; MAX_LAYERS], 0);
    let n_position = config.trunk.as_slice()[0];
    while let Some([width, n_out]) = config.trunk.layer(depth) {
        // The first layer reads the encoded position anyway.
        let skips = depth > 0 && config.skips >> depth & 1 == 1;
        let n_in = width.saturating_add(if skips { n_position } else { 0 });
        trunk[depth] = layer(LayerName::Trunk(depth as u8), [n_in, n_out])?;
        depth += 1;
    }
    let width = config.trunk.as_slice()[depth];
    let density = layer(LayerName::Density, [width, 1])?;
    let feature = match config.feature.width() {
        Some(n) => Some(layer(LayerName::Feature, [width, n])?),
        None => None,
    };
    let (mut color, mut n_color) = ([Dense::EMPTY; MAX_LAYERS], 0);
    while let Some(shape) = config.color.layer(n_color) {
        color[n_color] = layer(LayerName::Color(n_color as u8), shape)?;
        n_color += 1;
    }
    let bits = [config.skips, config.linear];
    let color = Mlp::new(&color[..n_color])?;
    let mut network = NerfNetwork::new(&trunk[..depth], bits, density, feature, color)?;
    network.feature_relu = matches!(config.feature, FeatureV1::Bent(_));
    Ok(network)
}

/// The weights of a field of this kind with their names, in the order of the file.
pub(crate) fn tensors<'f, 'a>(
    field: &'f AnyField<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    let field = match field {
        AnyField::Nerf(field) => Some(field),
        _ => None,
    };
    field.into_iter().flat_map(|field| {
        let positions = frequencies(&field.positions, TensorName::PositionFrequencies);
        let directions = field.directions.as_ref();
        let directions =
            directions.and_then(|encoding| frequencies(encoding, TensorName::DirectionFrequencies));
        let fine = layers(&field.fine, Network::Fine);
        let coarse = field.coarse.iter().flat_map(|network| layers(network, Network::Coarse));
        positions.into_iter().chain(directions).chain(fine).chain(coarse)
    })
}

fn frequencies<'a>(
    encoding: &Fourier<'a>,
    name: TensorName,
) -> Option<(TensorName, TensorView<'a>)> {
    match encoding.waves {
        Waves::Gaussian(matrix) => Some((name, matrix)),
        Waves::Octaves { .. } => None,
    }
}

fn layers<'f, 'a>(
    network: &'f NerfNetwork<'a>,
    which: Network,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    let trunk = (0..).zip(network.trunk()).map(|(i, layer)| (LayerName::Trunk(i), layer));
    let density = core::iter::once((LayerName::Density, &network.density));
    let feature = network.feature.iter().map(|layer| (LayerName::Feature, layer));
    let color = (0..).zip(network.color.layers()).map(|(i, layer)| (LayerName::Color(i), layer));
    trunk.chain(density).chain(feature).chain(color).flat_map(move |(name, layer)| {
        let weight = (TensorName::LayerWeight(which, name), layer.weight);
        let bias = layer.bias.map(|bias| (TensorName::LayerBias(which, name), bias));
        core::iter::once(weight).chain(bias)
    })
}
