//! A model as a GPU reads it: buffers of numbers, and what the shader is to know of them.

mod cells;
#[cfg(feature = "nerf")]
mod fourier;
mod hash_grid;
mod layer;
#[cfg(feature = "planes")]
mod planes;
mod tables;
#[cfg(feature = "nerf")]
mod vanilla;

#[cfg(feature = "nerf")]
use alloc::boxed::Box;
use alloc::vec::Vec;

use pocketnerf_core::AnyField;
use pocketnerf_core::encoding::spherical_harmonics;
use pocketnerf_core::field::{Decoder, Shading};
use pocketnerf_core::{DType, Error, Model, Space};

#[cfg(feature = "wgpu")]
pub(crate) use cells::pack as pack_cells;
#[cfg(feature = "nerf")]
pub(crate) use fourier::{PackedFourier, PackedWaves};
pub(crate) use hash_grid::{PackedGrid, PackedLevel};
pub(crate) use layer::{Layer, QUAD};
#[cfg(feature = "planes")]
pub(crate) use planes::PackedPlanes;
pub(crate) use tables::reader;
#[cfg(feature = "nerf")]
pub(crate) use vanilla::{PackedNetwork, PackedVanilla};

use layer::{Weights, first, padded};

/// A model's buffers.
#[derive(Debug, Default)]
pub struct Packed {
    /// Matrices and biases, rows of four numbers.
    pub weights: Vec<[f32; 4]>,
    /// Tables in their stored type, one after another, each from a whole word on.
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
    Encoded(PackedEncoded),
    #[cfg(feature = "nerf")]
    Vanilla(Box<PackedVanilla>),
}

impl Default for PackedField {
    fn default() -> Self {
        Self::Encoded(PackedEncoded::default())
    }
}

/// An encoding with tables, and the networks behind it.
#[derive(Debug, Default)]
pub(crate) struct PackedEncoded {
    pub(crate) encoding: PackedEncoding,
    /// The type of stored values.
    pub(crate) dtype: Option<DType>,
    /// Quads of features that the colour network reads.
    pub(crate) n_feature_quads: usize,
    pub(crate) density: Vec<Layer>,
    pub(crate) color: Vec<Layer>,
    /// Quads of harmonics of the direction.
    pub(crate) n_harmonics: usize,
    /// Whether colours are computed once a ray.
    pub(crate) per_ray: bool,
    pub(crate) log_density_bias: f32,
}

/// Where encoded values come from.
#[derive(Debug)]
pub(crate) enum PackedEncoding {
    HashGrid(PackedGrid),
    #[cfg(feature = "planes")]
    Planes(PackedPlanes),
}

impl Default for PackedEncoding {
    fn default() -> Self {
        Self::HashGrid(PackedGrid::default())
    }
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
                let encoding = hash_grid::pack(&field.grid, &mut packed.tables);
                let dtype = field.grid.levels[0].dtype();
                encoded(PackedEncoding::HashGrid(encoding), dtype, &field.decoder, &mut weights)
            }
            #[cfg(feature = "planes")]
            AnyField::Planes(field) => {
                let encoding = planes::pack(&field.planes, &mut packed.tables);
                let dtype = field.planes.pairs[0].plane.dtype();
                encoded(PackedEncoding::Planes(encoding), dtype, &field.decoder, &mut weights)
            }
            #[cfg(feature = "nerf")]
            AnyField::Nerf(field) => {
                PackedField::Vanilla(Box::new(vanilla::pack(field, &mut weights)))
            }
            // Voxels have no program, and what has no feature here.
            _ => return Err(Error::Unsupported("this kind of field")),
        };
        packed.weights = weights.rows;
        Ok(packed)
    }
}

/// The rows of a field's networks alone: see [`Packed::weights`].
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

fn encoded(
    encoding: PackedEncoding,
    dtype: DType,
    decoder: &Decoder<'_>,
    weights: &mut Weights,
) -> PackedField {
    let n_harmonics = spherical_harmonics::n_output(decoder.sh_degree);
    let [density, color] = networks(decoder, weights);
    PackedField::Encoded(PackedEncoded {
        encoding,
        dtype: Some(dtype),
        n_feature_quads: (decoder.n_features as usize).div_ceil(QUAD),
        density,
        color,
        n_harmonics: n_harmonics.div_ceil(QUAD),
        per_ray: decoder.shading == Shading::PerRay,
        log_density_bias: decoder.log_density_bias,
    })
}
