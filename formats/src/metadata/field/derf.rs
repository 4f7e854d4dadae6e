//! DeRF: FIELD is the shape of the heads.

use pocketnerf_core::TensorView;
use pocketnerf_core::field::{Activation, DerfField, HeadShape};
use serde::{Deserialize, Serialize};

use super::FieldKind;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, Role, TensorName};

/// Code of the sites.
const SITES: u8 = 27;
/// Code of the parameters of all heads.
const HEADS: u8 = 28;
/// Codes of [`Activation`], as of vanilla NeRFs.
const ACTIVATIONS: [Activation; 3] = [Activation::Relu, Activation::Softplus, Activation::Exp];

/// What FIELD says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DerfV1 {
    octaves: u32,
    direction_octaves: Option<u32>,
    depth: u32,
    width: u32,
    skip: u32,
    color_width: u32,
    activation: u8,
    density_scale: f32,
}

impl<'a> FieldKind<'a> for DerfField<'a> {
    const NAMES: &'static [Known] = &[
        Known { code: SITES, text: "sites", role: Role::Exact, several: false },
        Known { code: HEADS, text: "heads", role: Role::Network, several: false },
    ];
    const MAX_TENSORS: usize = 2;
    type Metadata = DerfV1;

    fn read(mut fields: Fields<'a>) -> Result<DerfV1, FormatError> {
        let derf: DerfV1 = fields.take()?;
        fields.finite("density_scale", &[derf.density_scale])?;
        if usize::from(derf.activation) >= ACTIVATIONS.len() {
            return Err(fields.unknown("activation", derf.activation));
        }
        fields.finish()?;
        Ok(derf)
    }

    fn open(metadata: &DerfV1, listed: &mut Listed<'a>) -> Result<Self, FormatError> {
        let DerfV1 { octaves, direction_octaves, depth, width, skip, color_width, .. } = *metadata;
        let activation = ACTIVATIONS[usize::from(metadata.activation)];
        Ok(Self {
            shape: HeadShape {
                octaves,
                direction_octaves,
                depth,
                width,
                skip,
                color_width,
                activation,
            },
            sites: listed.need(TensorName::new(SITES, 0))?,
            heads: listed.need(TensorName::new(HEADS, 0))?,
            density_scale: metadata.density_scale,
        })
    }

    fn metadata(&self) -> Option<DerfV1> {
        let HeadShape { octaves, direction_octaves, depth, width, skip, color_width, activation } =
            self.shape;
        let activation = ACTIVATIONS.iter().position(|a| *a == activation)? as u8;
        let density_scale = self.density_scale;
        Some(DerfV1 {
            octaves,
            direction_octaves,
            depth,
            width,
            skip,
            color_width,
            activation,
            density_scale,
        })
    }

    fn write<W: Extend<u8>>(metadata: &DerfV1, bytes: W) -> Option<W> {
        append(bytes, metadata)
    }

    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> {
        [(SITES, self.sites), (HEADS, self.heads)]
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
    fn bytes_of_derf_v1() {
        let metadata = DerfV1 {
            octaves: 10,
            direction_octaves: Some(4),
            depth: 3,
            width: 300,
            skip: 2,
            color_width: 16,
            activation: 2,
            density_scale: -2.0,
        };
        let mut bytes = DerfField::write(&metadata, Vec::new()).unwrap();
        assert_eq!(bytes, [10, 1, 4, 3, 0xac, 2, 2, 16, 2, 0, 0, 0, 0xc0]);
        let read = |bytes: &[u8]| {
            DerfField::read(Fields::open(&test_section(kind::FIELD, bytes)).unwrap())
        };
        assert_eq!(read(&bytes), Ok(metadata));
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        bytes[8] = 3;
        let unknown = FormatError::UnknownCode { section, field: "activation", found: 3 };
        assert_eq!(read(&bytes), Err(unknown));
    }
}
