//! Plenoxels: FIELD is the size of the grid, and how colours and densities are read.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::VoxelGrid;
use pocketnerf_core::field::PlenoxelField;
use serde::{Deserialize, Serialize};

use super::FieldKind;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, Role, TensorName};

/// Code of the numbers of the bricks.
const INDEX: u8 = 24;
/// Code of the values of their corners.
const VALUES: u8 = 25;

/// What FIELD says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlenoxelsV1 {
    resolution: u32,
    sh_degree: u32,
    log_density_bias: f32,
}

impl<'a> FieldKind<'a> for PlenoxelField<'a> {
    const NAMES: &'static [Known] = &[
        Known { code: INDEX, text: "voxel index", role: Role::Index, several: false },
        Known { code: VALUES, text: "voxels", role: Role::Table, several: false },
    ];
    const MAX_TENSORS: usize = 2;
    type Metadata = PlenoxelsV1;

    fn read(mut fields: Fields<'a>) -> Result<PlenoxelsV1, FormatError> {
        let metadata: PlenoxelsV1 = fields.take()?;
        fields.finite("log_density_bias", &[metadata.log_density_bias])?;
        fields.finish()?;
        Ok(metadata)
    }

    fn open(metadata: &PlenoxelsV1, listed: &mut Listed<'a>) -> Result<Self, FormatError> {
        let PlenoxelsV1 { resolution, sh_degree, log_density_bias } = *metadata;
        let index = listed.need(TensorName::new(INDEX, 0))?;
        let values = listed.need(TensorName::new(VALUES, 0))?;
        let grid = VoxelGrid { resolution, index, values };
        Ok(Self { grid, sh_degree, log_density_bias })
    }

    fn metadata(&self) -> Option<PlenoxelsV1> {
        let Self { grid, sh_degree, log_density_bias } = *self;
        Some(PlenoxelsV1 { resolution: grid.resolution, sh_degree, log_density_bias })
    }

    fn write<W: Extend<u8>>(metadata: &PlenoxelsV1, bytes: W) -> Option<W> {
        append(bytes, metadata)
    }

    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> {
        [(INDEX, self.grid.index), (VALUES, self.grid.values)]
            .into_iter()
            .map(|(code, view)| (TensorName::new(code, 0), view))
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::test_section;

    #[test]
    fn bytes_of_plenoxels_v1() {
        let metadata = PlenoxelsV1 { resolution: 256, sh_degree: 2, log_density_bias: -2.0 };
        let mut bytes = PlenoxelField::write(&metadata, Vec::new()).unwrap();
        assert_eq!(bytes, [0x80, 2, 2, 0, 0, 0, 0xc0]);
        let read = |bytes: &[u8]| {
            PlenoxelField::read(Fields::open(&test_section(kind::FIELD, bytes)).unwrap())
        };
        assert_eq!(read(&bytes), Ok(metadata));
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        bytes[5..].copy_from_slice(&[0xc0, 0x7f]);
        assert!(read(&bytes).is_err());
    }
}
