//! The networks of a vanilla NeRF.

use alloc::vec::Vec;

use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};

use super::fourier::{self, PackedFourier};
use super::layer::{Layer, Weights, first, padded};

#[derive(Debug)]
pub(crate) struct PackedVanilla {
    pub(crate) positions: PackedFourier,
    pub(crate) directions: Option<PackedFourier>,
    pub(crate) fine: PackedNetwork,
    /// `None`: the fine one places samples.
    pub(crate) coarse: Option<PackedNetwork>,
    /// From unit coordinates to those that are encoded: factors, then what is added.
    pub(crate) map: [[f32; 3]; 2],
    pub(crate) activation: Activation,
    pub(crate) density_scale: f32,
}

/// The layers of a vanilla NeRF.
#[derive(Debug)]
pub(crate) struct PackedNetwork {
    /// Each with whether it reads the encoded point once more, and whether ReLU follows.
    pub(crate) trunk: Vec<(Layer, bool, bool)>,
    pub(crate) density: Layer,
    pub(crate) feature: Option<(Layer, bool)>,
    pub(crate) color: Vec<Layer>,
}

pub(super) fn pack(field: &NerfField<'_>, weights: &mut Weights) -> PackedVanilla {
    let positions = fourier::pack(&field.positions, weights);
    let directions = field.directions.as_ref().map(|d| fourier::pack(d, weights));
    let mut network = |network: &NerfNetwork<'_>| {
        packed_network(network, &positions, directions.as_ref(), weights)
    };
    let fine = network(&field.fine);
    let coarse = field.coarse.as_ref().map(network);
    PackedVanilla {
        positions,
        directions,
        fine,
        coarse,
        map: [field.map.scale, field.map.offset],
        activation: field.activation,
        density_scale: field.density_scale,
    }
}

fn packed_network(
    network: &NerfNetwork<'_>,
    positions: &PackedFourier,
    directions: Option<&PackedFourier>,
    weights: &mut Weights,
) -> PackedNetwork {
    let mut width = 0;
    let mut trunk = Vec::new();
    for (i, layer) in network.trunk().iter().enumerate() {
        let again = i == 0 || network.skips(i);
        let mut inputs = if again { positions.order.clone() } else { Vec::new() };
        let read = if again { positions.n_output } else { 0 };
        inputs.extend(padded(read..read + width));
        width = layer.weight.cols();
        let packed = weights.layer(layer, &inputs, &first(width));
        trunk.push((packed, network.skips(i), network.relu_after(i)));
    }
    let density = weights.layer(&network.density, &first(width), &first(1));
    let feature = network.feature.as_ref().map(|layer| {
        let packed = weights.layer(layer, &first(width), &first(layer.weight.cols()));
        width = layer.weight.cols();
        (packed, network.feature_relu)
    });
    let mut inputs = first(width);
    if let Some(directions) = directions {
        inputs.extend(directions.order.iter().map(|at| at.map(|at| width + at)));
    }
    let color = weights.network(&network.color, &inputs, &first(3));
    PackedNetwork { trunk, density, feature, color }
}
