//! A model as a GPU reads it: buffers of numbers, and what the shader is to know of them.

mod cells;
#[cfg(feature = "nerf")]
mod fourier;
mod layer;
mod tables;
#[cfg(feature = "nerf")]
mod vanilla;

#[cfg(feature = "nerf")]
use alloc::boxed::Box;
use alloc::vec::Vec;

use pocketnerf_core::AnyField;
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::field::{Decoder, HashGridField, Shading};
use pocketnerf_core::{DType, Error, Model, Space};

#[cfg(feature = "wgpu")]
pub(crate) use cells::pack as pack_cells;
#[cfg(feature = "nerf")]
pub(crate) use fourier::{PackedFourier, PackedWaves};
pub(crate) use layer::{Layer, QUAD};
pub(crate) use tables::{PackedLevel, reader};
#[cfg(feature = "nerf")]
pub(crate) use vanilla::{PackedNetwork, PackedVanilla};

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
    #[cfg(feature = "nerf")]
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

impl Packed {
    /// Lays out `model`.
    ///
    /// # Errors
    /// Whatever [`Model::validate`] reports, [`Error::Feature`], or [`Error::Unsupported`] for voxels.
    pub fn new(model: &Model<'_>) -> Result<Self, Error> {
        model.validate()?;
        match model.space {
            Space::Ndc(_) if cfg!(not(feature = "ndc")) => return Err(Error::Feature("ndc")),
            Space::Contracted(_) if cfg!(not(feature = "contracted")) => {
                return Err(Error::Feature("contracted"));
            }
            _ => {}
        }
        let mut packed =
            Self { occupancy: cells::pack(model.occupancy.as_ref()), ..Self::default() };
        let mut weights = Weights::default();
        packed.field = match &model.field {
            AnyField::HashGrid(field) => {
                PackedField::HashGrid(grid(field, &mut weights, &mut packed.tables))
            }
            #[cfg(feature = "nerf")]
            AnyField::Nerf(field) => {
                PackedField::Vanilla(Box::new(vanilla::pack(field, &mut weights)))
            }
            // Voxels have no program.
            _ => return Err(Error::Unsupported("this kind of field")),
        };
        packed.weights = weights.rows;
        Ok(packed)
    }
}

/// The rows of a grid's networks alone: see [`Packed::weights`].
#[cfg(feature = "wgpu")]
pub(crate) fn network_rows(decoder: &Decoder<'_>) -> Vec<[f32; 4]> {
    let mut weights = Weights::default();
    let _ = networks(decoder, &mut weights);
    weights.rows
}

/// The density network and the colour network.
fn networks(decoder: &Decoder<'_>, weights: &mut Weights) -> [Vec<Layer>; 2] {
    let n = decoder.n_features as usize;
    // Features first, then the log density in a quad of its own.
    let mut outputs = padded(1..n + 1);
    outputs.extend_from_slice(&first(1));
    let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
    let mut inputs = first(n);
    inputs.extend_from_slice(&padded(n..n + n_harmonics));
    let encoded = first(decoder.density.n_input());
    let density = weights.network(&decoder.density, &encoded, &outputs);
    [density, weights.network(&decoder.color, &inputs, &first(3))]
}

fn grid(field: &HashGridField<'_>, weights: &mut Weights, tables: &mut Vec<u32>) -> PackedGrid {
    let (grid, decoder) = (&field.grid, &field.decoder);
    let n = decoder.n_features as usize;
    let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
    let [density, color] = networks(decoder, weights);
    PackedGrid {
        n_features_per_level: grid.config.n_features_per_level as usize,
        n_feature_quads: n.div_ceil(QUAD),
        per_ray: decoder.shading == Shading::PerRay,
        log_density_bias: decoder.log_density_bias,
        by_corner: grid.config.level(0).is_by_corner(),
        dtype: Some(grid.levels[0].dtype()),
        levels: tables::pack(grid, tables),
        density,
        color,
        n_harmonics: n_harmonics.div_ceil(QUAD),
    }
}
