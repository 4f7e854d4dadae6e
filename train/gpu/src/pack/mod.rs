//! A model as a GPU reads it: buffers of numbers, and what the shader is to know of them.

mod cells;
mod fourier;
mod layer;
mod tables;

use alloc::boxed::Box;
use alloc::vec::Vec;

use pocketnerf_core::AnyField;
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::field::{Activation, HashGridField, NerfField, NerfNetwork, Shading};
use pocketnerf_core::{DType, Error, Model};

pub(crate) use fourier::{PackedFourier, PackedWaves};
pub(crate) use layer::{Layer, QUAD};
pub(crate) use tables::{PackedLevel, reader};

use layer::{Weights, first, padded};

/// A model's buffers.
#[derive(Debug, Default)]
pub struct Packed {
    /// Matrices and biases, rows of four numbers.
    pub weights: Vec<[f32; 4]>,
    /// Hash tables in their stored type, one after another, each from a whole word on.
    pub tables: Vec<u32>,
    /// A word a block of cells: the number of its cells' bits, or, with the highest bit set,
    /// the side of the cube of empty cells that it is a part of. Then 16 words for each block
    /// that is not empty.
    pub occupancy: Vec<u32>,
    pub(crate) field: PackedField,
}

/// What the shader is to know of a field.
#[derive(Debug)]
pub(crate) enum PackedField {
    HashGrid(PackedGrid),
    Vanilla(Box<PackedVanilla>),
}

impl Default for PackedField {
    fn default() -> Self {
        Self::HashGrid(PackedGrid::default())
    }
}

#[derive(Debug, Default)]
pub(crate) struct PackedGrid {
    /// Values of an entry.
    pub(crate) n_features_per_level: usize,
    /// Quads of features that the colour network reads.
    pub(crate) n_feature_quads: usize,
    pub(crate) by_corner: bool,
    pub(crate) dtype: Option<DType>,
    pub(crate) levels: Vec<PackedLevel>,
    pub(crate) density: Vec<Layer>,
    pub(crate) color: Vec<Layer>,
    /// Quads of harmonics of the direction.
    pub(crate) n_harmonics: usize,
    /// Whether colours are computed once a ray.
    pub(crate) per_ray: bool,
    pub(crate) log_density_bias: f32,
}

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

impl Packed {
    /// Lays out `model`.
    ///
    /// # Errors
    /// Whatever [`Model::validate`] reports.
    pub fn new(model: &Model<'_>) -> Result<Self, Error> {
        model.validate()?;
        let mut packed =
            Self { occupancy: cells::pack(model.occupancy.as_ref()), ..Self::default() };
        let mut weights = Weights::default();
        packed.field = match &model.field {
            AnyField::HashGrid(field) => {
                PackedField::HashGrid(grid(field, &mut weights, &mut packed.tables))
            }
            AnyField::Nerf(field) => PackedField::Vanilla(Box::new(vanilla(field, &mut weights))),
            _ => return Err(Error::Feature("this kind of field on a GPU")),
        };
        packed.weights = weights.rows;
        Ok(packed)
    }
}

fn grid(field: &HashGridField<'_>, weights: &mut Weights, tables: &mut Vec<u32>) -> PackedGrid {
    let (grid, decoder) = (&field.grid, &field.decoder);
    let n = decoder.n_features as usize;
    // Features first, then the log density in a quad of its own.
    let features = (1..=n).map(Some);
    let outputs = [padded(features), padded([Some(0)])].concat();
    let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
    let harmonics = (n..n + n_harmonics).map(Some);
    let inputs = [first(n), padded(harmonics)].concat();
    PackedGrid {
        n_features_per_level: grid.config.n_features_per_level as usize,
        n_feature_quads: n.div_ceil(QUAD),
        per_ray: decoder.shading == Shading::PerRay,
        log_density_bias: decoder.log_density_bias,
        by_corner: grid.config.level(0).is_by_corner(),
        dtype: Some(grid.levels[0].dtype()),
        levels: tables::pack(grid, tables),
        density: weights.network(&decoder.density, &first(decoder.density.n_input()), &outputs),
        color: weights.network(&decoder.color, &inputs, &first(3)),
        n_harmonics: n_harmonics.div_ceil(QUAD),
    }
}

fn vanilla(field: &NerfField<'_>, weights: &mut Weights) -> PackedVanilla {
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
        inputs.extend(padded((read..read + width).map(Some)));
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
