//! The tensors of vanilla NeRFs.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, MAX_LAYERS, Mlp};

use super::{FeatureV1, FourierV1, NerfV1, NetworkV1};
use crate::FormatError;
use crate::directory::{Listed, expect_shape};
use crate::tensor_name::{Known, Role, TensorName};

const POSITION_FREQUENCIES: TensorName = TensorName::new(5, 0);
const DIRECTION_FREQUENCIES: TensorName = TensorName::new(6, 0);
/// First codes of the two networks.
const FINE: u8 = 7;
const COARSE: u8 = 15;
/// Codes of the weights of a network's layers, from its first one. A bias has the code after
/// its weight's.
const TRUNK: u8 = 0;
const DENSITY: u8 = 2;
const FEATURE: u8 = 4;
const COLOR: u8 = 6;

pub(super) const NAMES: &[Known] = &[
    Known { code: 5, text: "position frequencies", role: Role::Exact, several: false },
    Known { code: 6, text: "direction frequencies", role: Role::Exact, several: false },
    Known::layers(7, "fine trunk weight"),
    Known::layers(8, "fine trunk bias"),
    single(9, "fine density weight"),
    single(10, "fine density bias"),
    single(11, "fine feature weight"),
    single(12, "fine feature bias"),
    Known::layers(13, "fine colour weight"),
    Known::layers(14, "fine colour bias"),
    Known::layers(15, "coarse trunk weight"),
    Known::layers(16, "coarse trunk bias"),
    single(17, "coarse density weight"),
    single(18, "coarse density bias"),
    single(19, "coarse feature weight"),
    single(20, "coarse feature bias"),
    Known::layers(21, "coarse colour weight"),
    Known::layers(22, "coarse colour bias"),
];
/// Frequencies; weights and biases of two networks of trunk, density, feature and colour.
pub(super) const MAX_TENSORS: usize = 2 + 2 * 2 * (2 * MAX_LAYERS + 2);

/// The weight or the bias of a layer that is not numbered.
const fn single(code: u8, text: &'static str) -> Known {
    Known { several: false, ..Known::layers(code, text) }
}

/// The names of weight and bias of a network's layer.
const fn layer(network: u8, layer: u8, index: u32) -> [TensorName; 2] {
    let code = network + layer;
    [TensorName::new(code, index), TensorName::new(code + 1, index)]
}

/// The field that FIELD describes.
pub(super) fn open<'a>(
    config: &NerfV1,
    listed: &mut Listed<'a>,
) -> Result<NerfField<'a>, FormatError> {
    let positions = fourier(&config.positions, POSITION_FREQUENCIES, listed)?;
    let directions = match &config.directions {
        Some(encoding) => Some(fourier(encoding, DIRECTION_FREQUENCIES, listed)?),
        None => None,
    };
    let fine = network(&config.fine, FINE, listed)?;
    let coarse = match &config.coarse {
        Some(config) => Some(network(config, COARSE, listed)?),
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
    which: u8,
    listed: &mut Listed<'a>,
) -> Result<NerfNetwork<'a>, FormatError> {
    let mut take =
        |code, index: usize, shape| listed.layer(layer(which, code, index as u32), shape);
    let (mut trunk, mut depth) = ([Dense::EMPTY; MAX_LAYERS], 0);
    let n_position = config.trunk.as_slice()[0];
    while let Some([width, n_out]) = config.trunk.layer(depth) {
        // The first layer reads the encoded position anyway.
        let skips = depth > 0 && config.skips >> depth & 1 == 1;
        let n_in = width.saturating_add(if skips { n_position } else { 0 });
        trunk[depth] = take(TRUNK, depth, [n_in, n_out])?;
        depth += 1;
    }
    let width = config.trunk.as_slice()[depth];
    let density = take(DENSITY, 0, [width, 1])?;
    let feature = match config.feature.width() {
        Some(n) => Some(take(FEATURE, 0, [width, n])?),
        None => None,
    };
    let (mut color, mut n_color) = ([Dense::EMPTY; MAX_LAYERS], 0);
    while let Some(shape) = config.color.layer(n_color) {
        color[n_color] = take(COLOR, n_color, shape)?;
        n_color += 1;
    }
    let bits = [config.skips, config.linear];
    let color = Mlp::new(&color[..n_color])?;
    let mut network = NerfNetwork::new(&trunk[..depth], bits, density, feature, color)?;
    network.feature_relu = matches!(config.feature, FeatureV1::Bent(_));
    Ok(network)
}

/// The weights of a field of this kind with their names, in the order of the file.
pub(super) fn tensors<'f, 'a>(
    field: &'f NerfField<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    let positions = frequencies(&field.positions, POSITION_FREQUENCIES);
    let directions = field.directions.as_ref();
    let directions = directions.and_then(|encoding| frequencies(encoding, DIRECTION_FREQUENCIES));
    let fine = layers(&field.fine, FINE);
    let coarse = field.coarse.iter().flat_map(|network| layers(network, COARSE));
    positions.into_iter().chain(directions).chain(fine).chain(coarse)
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
    which: u8,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    let one = |code| move |layer| (code, 0, layer);
    let row = |code| move |(i, layer)| (code, i, layer);
    let trunk = (0..).zip(network.trunk()).map(row(TRUNK));
    let density = core::iter::once(&network.density).map(one(DENSITY));
    let feature = network.feature.iter().map(one(FEATURE));
    let color = (0..).zip(network.color.layers()).map(row(COLOR));
    trunk.chain(density).chain(feature).chain(color).flat_map(move |(code, index, dense)| {
        let [weight, bias] = layer(which, code, index);
        let bias = dense.bias.map(|view| (bias, view));
        core::iter::once((weight, dense.weight)).chain(bias)
    })
}
