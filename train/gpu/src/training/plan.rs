//! What is to be trained: which fields can be, their layers, and the text of their program.

use pocketnerf_core::field::{HashGridField, Shading};
use pocketnerf_core::network::Mlp;
use pocketnerf_core::{AnyField, DType, Model};

use super::networks::Networks;
use crate::pack::{Packed, PackedEncoded, PackedEncoding, PackedField};
use crate::render::Error;
use crate::shader::training_source;

/// Values of an entry with which workgroups evaluate samples together.
const TOGETHER: u32 = 4;

/// A field that can be trained.
pub(super) struct Plan<'m> {
    pub(super) field: &'m HashGridField<'m>,
    pub(super) packed: Packed,
    pub(super) networks: Networks,
    pub(super) n_feature_quads: u32,
    /// The program.
    pub(super) source: String,
}

impl<'m> Plan<'m> {
    pub(super) fn new(model: &'m Model<'m>) -> Result<Self, Error> {
        let AnyField::HashGrid(field) = &model.field else {
            return Err(Error::Untrainable("this kind of field"));
        };
        let is_bytes = field.grid.levels[0].dtype() == DType::I8;
        if field.decoder.shading != Shading::PerRay || !is_bytes {
            return Err(Error::Untrainable("fields whose samples have colours of their own"));
        }
        if field.grid.config.level(0).is_by_corner() {
            return Err(Error::Untrainable("grids of other programs"));
        }
        let packed = Packed::new(model)?;
        let PackedField::Encoded(
            encoded @ PackedEncoded { encoding: PackedEncoding::HashGrid(grid), .. },
        ) = &packed.field
        else {
            return Err(Error::Untrainable("this kind of field"));
        };
        let decoder = &field.decoder;
        let [density, color] = [&decoder.density, &decoder.color].map(widths);
        let mut networks = Networks::new(density, color, decoder.n_features);
        if field.grid.config.n_features_per_level != TOGETHER {
            networks.rows.together = None;
        }
        let source = training_source(model, (encoded, grid), &networks.rows);
        let n_feature_quads = encoded.n_feature_quads as u32;
        Ok(Self { field, packed, networks, n_feature_quads, source })
    }
}

/// From input to output.
fn widths(network: &Mlp<'_>) -> Vec<u32> {
    let layers = network.layers();
    let first = layers.first().map(|layer| layer.weight.rows());
    let rest = layers.iter().map(|layer| layer.weight.cols());
    first.into_iter().chain(rest).map(|width| width as u32).collect()
}

/// The text in WGSL of the program that trains fields like that of `model`, whose tables are
/// bytes.
///
/// # Errors
/// [`Error::Untrainable`] for other fields.
pub fn source(model: &Model<'_>) -> Result<String, Error> {
    Ok(Plan::new(model)?.source)
}
