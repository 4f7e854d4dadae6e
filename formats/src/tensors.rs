//! TENSORS: the directory of the weights.

use core::fmt;

use pocketnerf_core::encoding::MAX_LEVELS;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::network::{MAX_LAYERS, Mlp};
use pocketnerf_core::{AnyField, DType, Layout, TensorView};
use serde::{Deserialize, Serialize};

use crate::container::Container;
use crate::metadata::Fields;
use crate::section::SectionId;
use crate::{FormatError, reader};

/// Which of a field's weights a tensor is. Levels and layers count from 0.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TensorName {
    /// The table of a hash grid level.
    GridLevel(u32),
    /// The weight of a layer of the density network.
    DensityWeight(u32),
    /// The bias of a layer of the density network.
    DensityBias(u32),
    /// The weight of a layer of the colour network.
    ColorWeight(u32),
    /// The bias of a layer of the colour network.
    ColorBias(u32),
}

impl fmt::Display for TensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GridLevel(i) => write!(f, "grid level {i}"),
            Self::DensityWeight(i) => write!(f, "density weight {i}"),
            Self::DensityBias(i) => write!(f, "density bias {i}"),
            Self::ColorWeight(i) => write!(f, "colour weight {i}"),
            Self::ColorBias(i) => write!(f, "colour bias {i}"),
        }
    }
}

impl TensorName {
    /// Code and index in the file.
    #[cfg(feature = "alloc")]
    const fn code(self) -> (u8, u32) {
        match self {
            Self::GridLevel(i) => (0, i),
            Self::DensityWeight(i) => (1, i),
            Self::DensityBias(i) => (2, i),
            Self::ColorWeight(i) => (3, i),
            Self::ColorBias(i) => (4, i),
        }
    }

    const fn from_code(code: u8, index: u32) -> Option<Self> {
        Some(match code {
            0 => Self::GridLevel(index),
            1 => Self::DensityWeight(index),
            2 => Self::DensityBias(index),
            3 => Self::ColorWeight(index),
            4 => Self::ColorBias(index),
            _ => return None,
        })
    }
}

/// The weights of a field with their names, in the order of the file.
pub fn tensors<'f, 'a>(
    field: &'f AnyField<'a>,
) -> impl Iterator<Item = (TensorName, TensorView<'a>)> + 'f {
    parts(field).into_iter().flat_map(|(grid, decoder)| {
        let grid = (0..).zip(grid).map(|(l, table)| (TensorName::GridLevel(l), *table));
        let density = layers(&decoder.density, TensorName::DensityWeight, TensorName::DensityBias);
        let color = layers(&decoder.color, TensorName::ColorWeight, TensorName::ColorBias);
        grid.chain(density).chain(color)
    })
}

/// Grid levels and decoder of a field; `None` for a kind that the format lacks.
pub(crate) fn parts<'f, 'a>(
    field: &'f AnyField<'a>,
) -> Option<(&'f [TensorView<'a>], &'f Decoder<'a>)> {
    match field {
        #[cfg(feature = "hash-grid")]
        AnyField::HashGrid(field) => {
            let n_levels = (field.grid.config.n_levels as usize).min(MAX_LEVELS);
            Some((&field.grid.levels[..n_levels], &field.decoder))
        }
        #[cfg(feature = "frequency")]
        AnyField::Frequency(field) => Some((&[], &field.decoder)),
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

/// Most tensors a field may have.
pub(crate) const MAX_TENSORS: usize = MAX_LEVELS + 4 * MAX_LAYERS;

/// One entry of the directory; TENSORS is their number (`u32`), then these.
#[derive(Serialize, Deserialize)]
struct TensorV1 {
    name: u8,
    index: u32,
    dtype: u8,
    rows: u32,
    cols: u32,
    scale_log2: i8,
    layout: u8,
    section_kind: u32,
    section_index: u32,
}

/// The section's bytes: an entry for each tensor and the section that holds it.
#[cfg(feature = "alloc")]
pub(crate) fn write_directory<'a>(
    entries: impl ExactSizeIterator<Item = (TensorName, TensorView<'a>, SectionId)>,
) -> Option<alloc::vec::Vec<u8>> {
    let mut bytes = crate::metadata::encode(&(entries.len() as u32));
    for (name, view, section) in entries {
        let (name, index) = name.code();
        let entry = TensorV1 {
            name,
            index,
            dtype: match view.dtype() {
                DType::F32 => 0,
                DType::F16 => 1,
                DType::I8 => 2,
                _ => return None,
            },
            rows: view.shape()[0],
            cols: view.shape()[1],
            scale_log2: view.scale_log2(),
            layout: match view.layout() {
                Layout::RowMajor => 0,
                _ => return None,
            },
            section_kind: section.kind,
            section_index: section.index,
        };
        bytes.extend(crate::metadata::encode(&entry));
    }
    Some(bytes)
}

/// The weights of a field, sorted by name.
pub(crate) struct Tensors<'a> {
    pub(crate) grid: [Option<TensorView<'a>>; MAX_LEVELS],
    pub(crate) density_weight: [Option<TensorView<'a>>; MAX_LAYERS],
    pub(crate) density_bias: [Option<TensorView<'a>>; MAX_LAYERS],
    pub(crate) color_weight: [Option<TensorView<'a>>; MAX_LAYERS],
    pub(crate) color_bias: [Option<TensorView<'a>>; MAX_LAYERS],
}

impl<'a> Tensors<'a> {
    /// Reads the directory and finds the sections it names.
    pub(crate) fn read(
        container: &Container<'a>,
        mut fields: Fields<'a>,
    ) -> Result<Self, FormatError> {
        let mut tensors = Self {
            grid: [None; MAX_LEVELS],
            density_weight: [None; MAX_LAYERS],
            density_bias: [None; MAX_LAYERS],
            color_weight: [None; MAX_LAYERS],
            color_bias: [None; MAX_LAYERS],
        };
        let count: u32 = fields.take()?;
        fields.check("number of tensors", count as usize <= MAX_TENSORS)?;
        for _ in 0..count {
            let entry: TensorV1 = fields.take()?;
            let name = TensorName::from_code(entry.name, entry.index)
                .ok_or_else(|| fields.unknown("name of a tensor", entry.name))?;
            let view = entry.view(name, container, &fields)?;
            match tensors.place(name) {
                Some(free @ None) => *free = Some(view),
                _ => return Err(FormatError::UnexpectedTensor(name)),
            }
        }
        fields.finish()?;
        Ok(tensors)
    }

    fn place(&mut self, name: TensorName) -> Option<&mut Option<TensorView<'a>>> {
        let (places, index) = match name {
            TensorName::GridLevel(i) => (&mut self.grid[..], i),
            TensorName::DensityWeight(i) => (&mut self.density_weight[..], i),
            TensorName::DensityBias(i) => (&mut self.density_bias[..], i),
            TensorName::ColorWeight(i) => (&mut self.color_weight[..], i),
            TensorName::ColorBias(i) => (&mut self.color_bias[..], i),
        };
        places.get_mut(index as usize)
    }
}

impl TensorV1 {
    fn view<'a>(
        &self,
        name: TensorName,
        container: &Container<'a>,
        fields: &Fields<'_>,
    ) -> Result<TensorView<'a>, FormatError> {
        let dtype = match self.dtype {
            0 => DType::F32,
            1 => DType::F16,
            2 => DType::I8,
            code => return Err(fields.unknown("type of a tensor", code)),
        };
        // f32 needs no help with its range, and scaled it could overflow.
        let unscaled = dtype != DType::F32 || self.scale_log2 == 0;
        fields.check("scale_log2 of an f32 tensor", unscaled)?;
        let layout = match self.layout {
            0 => Layout::RowMajor,
            code => return Err(fields.unknown("layout of a tensor", code)),
        };
        let id = SectionId { kind: self.section_kind, index: self.section_index };
        let section = reader::need(container, id)?;
        TensorView::new(section.bytes, dtype, [self.rows, self.cols], self.scale_log2, layout)
            .map_err(|error| FormatError::Tensor(name, error))
    }
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_tensor_v1() {
        let view =
            TensorView::new(&[0; 2400], DType::F16, [300, 4], -20, Layout::RowMajor).unwrap();
        let section = SectionId { kind: crate::kind::GRID, index: 3 };
        let entry = (TensorName::GridLevel(3), view, section);
        let bytes = write_directory([entry].into_iter()).unwrap();
        assert_eq!(bytes, [1, 0, 3, 1, 0xac, 0x02, 4, 0xec, 0, 16, 3]);
    }

    #[test]
    fn names_have_codes_of_their_own() {
        for code in 0..=255 {
            if let Some(name) = TensorName::from_code(code, 9) {
                assert_eq!(name.code(), (code, 9));
            } else {
                assert!(code > 4);
            }
        }
    }
}
