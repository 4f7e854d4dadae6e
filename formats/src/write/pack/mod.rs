//! From an ordinary file to a packed one.

mod ans;
mod bits;
mod cells;
mod halves;
#[cfg(feature = "planes")]
mod planes;
mod tables;
mod unused;
#[cfg(feature = "planes")]
mod unused_planes;
#[cfg(feature = "plenoxels")]
mod unused_voxels;
#[cfg(feature = "plenoxels")]
mod voxels;

#[cfg(feature = "planes")]
pub use planes::packed_plane_len;

use alloc::borrow::Cow;
use alloc::vec::Vec;

#[cfg(feature = "plenoxels")]
use pocketnerf_core::{AnyField, DType, encoding::spherical_harmonics};

use super::{ContainerWriter, WriteError};
use crate::container::{Container, RAW, kind};
#[cfg(feature = "planes")]
use crate::packed::PACKED_PLANES;
use crate::packed::{PACKED_BLOCKS, PACKED_CELLS, PACKED_HALVES, PACKED_TABLE};
#[cfg(feature = "plenoxels")]
use crate::packed::{PACKED_VOXELS, voxels::Shape};
use crate::{ModelFile, reader};

/// Bytes of a table's values that lie together, where nothing else is known.
const BLOCK: u8 = 32;

/// The same model in fewer bytes: tables, occupancy and rounded networks are packed, and entries
/// of tables that no occupied cell reaches, which no picture and no answer depends on, become 0.
/// [`unpack_into`](crate::unpack_into) gives an ordinary file that renders to the same bytes. A
/// section that packing would not make smaller stays as it is.
///
/// # Errors
/// [`WriteError::Unreadable`] for a file that [`open_verified`](crate::open_verified) refuses, a
/// packed one among them.
pub fn pack(bytes: &[u8]) -> Result<Vec<u8>, WriteError> {
    let file = reader::open_verified(bytes)?;
    let mut writer = ContainerWriter::new();
    for section in file.sections() {
        if section.encoding != RAW {
            writer.add_section(&section);
            continue;
        }
        let payload = match section.id.kind {
            kind::GRID if !is_checkpoint(&file) => {
                unused::cleared(&file, section.id.index as usize, section.bytes)
            }
            _ => Cow::Borrowed(section.bytes),
        };
        let packed = match section.id.kind {
            kind::GRID => pack_grid(&file, section.id.index as usize, &payload),
            kind::NETWORK => halves::pack(&payload).map(|packed| (PACKED_HALVES, packed)),
            kind::OCC_COARSE => {
                cells::pack_blocks(&payload, side(&file)).map(|packed| (PACKED_BLOCKS, packed))
            }
            kind::OCC_FINE => cells::pack_bits(&payload).map(|packed| (PACKED_CELLS, packed)),
            _ => None,
        };
        let critical = section.is_critical();
        match packed.filter(|(_, packed)| packed.len() < payload.len()) {
            Some((encoding, packed)) => {
                let length = payload.len() as u64;
                writer.add_packed(
                    (section.id, section.version, critical),
                    encoding,
                    length,
                    packed,
                );
            }
            None => writer.add(section.id, section.version, critical, payload),
        }
    }
    let packed = writer.finish()?;
    Container::open(&packed)?;
    Ok(packed)
}

/// A trainer goes on from all of its parameters.
fn is_checkpoint(file: &ModelFile<'_>) -> bool {
    file.sections().any(|section| section.id.kind >= kind::PROGRAM)
}

/// Blocks of the occupancy along an axis; 0 where there is none.
fn side(file: &ModelFile<'_>) -> usize {
    let occupancy = file.model.occupancy.filter(|occupancy| occupancy.n_cascades() == 1);
    occupancy.map_or(0, |o| (o.resolution() / pocketnerf_core::occupancy::BLOCK) as usize)
}

/// A table: the values of voxels, a plane, or entries of any other kind.
fn pack_grid(file: &ModelFile<'_>, index: usize, payload: &[u8]) -> Option<(u16, Vec<u8>)> {
    let table = tables::pack(payload, block_of(file, index)).map(|packed| (PACKED_TABLE, packed));
    #[cfg(feature = "plenoxels")]
    if let Some(packed) = shape(file, index).and_then(|shape| voxels::pack(payload, shape))
        && table.as_ref().is_none_or(|(_, table)| packed.len() < table.len())
    {
        return Some((PACKED_VOXELS, packed));
    }
    #[cfg(feature = "planes")]
    if let Some(packed) = planes::row(file, index).and_then(|row| planes::pack(payload, row))
        && table.as_ref().is_none_or(|(_, table)| packed.len() < table.len())
    {
        return Some((PACKED_PLANES, packed));
    }
    table
}

/// What the corners of voxels hold, where this is their table.
#[cfg(feature = "plenoxels")]
fn shape(file: &ModelFile<'_>, index: usize) -> Option<Shape> {
    let AnyField::Plenoxels(field) = &file.model.field else { return None };
    let values = field.grid.values;
    if index > 0 || values.dtype() != DType::I8 {
        return None;
    }
    let width = u8::try_from(values.cols()).ok()?;
    let harmonics = u8::try_from(spherical_harmonics::n_output(field.sh_degree)).ok()?;
    Some(Shape { width, harmonics })
}

/// Bytes of the entries of a table that are used together: eight entries.
fn block_of(file: &ModelFile<'_>, level: usize) -> u8 {
    #[cfg(feature = "plenoxels")]
    if let (AnyField::Plenoxels(field), 0) = (&file.model.field, level) {
        // Of one corner.
        let values = field.grid.values;
        return u8::try_from(values.bytes().len() / values.rows().max(1)).unwrap_or(BLOCK);
    }
    let grid = unused::grid(file);
    let table = grid.and_then(|grid| grid.levels.get(level));
    let bytes = table.map(|table| 8 * table.bytes().len() / table.rows().max(1));
    bytes.and_then(|bytes| u8::try_from(bytes).ok()).unwrap_or(BLOCK)
}
