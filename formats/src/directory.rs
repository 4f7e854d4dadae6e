//! TENSORS: the directory of the weights.

use pocketnerf_core::network::Dense;
use pocketnerf_core::{DType, Layout, TensorView};
use serde::{Deserialize, Serialize};

use crate::container::{Container, SectionId};
use crate::metadata::field::MAX_TENSORS;
use crate::metadata::{Fields, append};
use crate::tensor_name::TensorName;
use crate::{FormatError, reader};

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

/// Appends the section: an entry for each tensor and the section that holds it.
pub(crate) fn write_directory<'a, W: Extend<u8>>(
    entries: impl ExactSizeIterator<Item = (TensorName, TensorView<'a>, SectionId)>,
    bytes: W,
) -> Option<W> {
    let mut bytes = append(bytes, &(entries.len() as u32))?;
    for (name, view, section) in entries {
        let entry = TensorV1 {
            name: name.code,
            index: name.index,
            dtype: match view.dtype() {
                DType::F32 => 0,
                DType::F16 => 1,
                DType::I8 => 2,
                DType::U16 => 3,
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
        bytes = append(bytes, &entry)?;
    }
    Some(bytes)
}

/// The listed tensors that have not been taken yet.
pub(crate) struct Listed<'a> {
    tensors: [Option<(TensorName, TensorView<'a>)>; MAX_TENSORS],
}

impl<'a> Listed<'a> {
    /// Reads the directory and finds the sections it names.
    pub(crate) fn read(
        container: &Container<'a>,
        mut fields: Fields<'a>,
    ) -> Result<Self, FormatError> {
        let mut listed = Self { tensors: [None; MAX_TENSORS] };
        let count: u32 = fields.take()?;
        fields.check("number of tensors", count as usize <= MAX_TENSORS)?;
        for i in 0..count as usize {
            let entry: TensorV1 = fields.take()?;
            let name = TensorName::known(entry.name, entry.index)
                .ok_or_else(|| fields.unknown("name of a tensor", entry.name))?;
            let view = entry.view(name, container, &fields)?;
            if listed.find(name).is_some() {
                return Err(FormatError::UnexpectedTensor(name));
            }
            listed.tensors[i] = Some((name, view));
        }
        fields.finish()?;
        Ok(listed)
    }

    #[inline(always)]
    fn find(&mut self, name: TensorName) -> Option<&mut Option<(TensorName, TensorView<'a>)>> {
        self.tensors.iter_mut().find(|tensor| tensor.is_some_and(|(other, _)| other == name))
    }

    /// Takes a tensor, if it is listed.
    pub(crate) fn take(&mut self, name: TensorName) -> Option<TensorView<'a>> {
        self.find(name)?.take().map(|(_, view)| view)
    }

    /// Takes a tensor that the field needs.
    pub(crate) fn need(&mut self, name: TensorName) -> Result<TensorView<'a>, FormatError> {
        self.take(name).ok_or(FormatError::MissingTensor(name))
    }

    /// Takes the weight of a layer, of this shape, and its bias, if it is listed.
    pub(crate) fn layer(
        &mut self,
        [weight_name, bias_name]: [TensorName; 2],
        [n_in, n_out]: [u32; 2],
    ) -> Result<Dense<'a>, FormatError> {
        let weight = self.need(weight_name)?;
        expect_shape(weight_name, &weight, [n_in, n_out])?;
        let bias = self.take(bias_name);
        if let Some(bias) = &bias {
            expect_shape(bias_name, bias, [1, n_out])?;
        }
        Ok(Dense { weight, bias })
    }

    /// Checks that nothing is left.
    pub(crate) fn finish(&self) -> Result<(), FormatError> {
        match self.tensors.iter().flatten().next() {
            Some((name, _)) => Err(FormatError::UnexpectedTensor(*name)),
            None => Ok(()),
        }
    }
}

pub(crate) fn expect_shape(
    tensor: TensorName,
    view: &TensorView<'_>,
    expected: [u32; 2],
) -> Result<(), FormatError> {
    let found = view.shape();
    if found == expected {
        Ok(())
    } else {
        Err(FormatError::TensorShape { tensor, expected, found })
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
            3 => DType::U16,
            code => return Err(fields.unknown("type of a tensor", code)),
        };
        // A scaled f32 could overflow, and an index has no scale.
        let unscaled = !matches!(dtype, DType::F32 | DType::U16) || self.scale_log2 == 0;
        fields.check("scale_log2 of an f32 or index tensor", unscaled)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_tensor_v1() {
        let view =
            TensorView::new(&[0; 2400], DType::F16, [300, 4], -20, Layout::RowMajor).unwrap();
        let section = SectionId { kind: crate::container::kind::GRID, index: 3 };
        let entry = (TensorName::new(0, 3), view, section);
        let bytes = write_directory([entry].into_iter(), alloc::vec::Vec::new()).unwrap();
        assert_eq!(bytes, [1, 0, 3, 1, 0xac, 0x02, 4, 0xec, 0, 16, 3]);
    }
}
