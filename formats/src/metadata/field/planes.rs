//! Planes and lines: FIELD is their size, then the decoder.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::Planes;
use pocketnerf_core::encoding::planes::{MAX_PAIRS, Pair};
use pocketnerf_core::field::PlanesField;
use serde::{Deserialize, Serialize};

use super::FieldKind;
use super::decoder;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, Role, TensorName};

/// Code of the tables: number 2 p is the plane of pair p, number 2 p + 1 its line.
const TABLE: u8 = 26;

/// The planes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PlanesV1 {
    resolution: u32,
    n_components: u32,
}

/// What FIELD says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metadata {
    planes: PlanesV1,
    decoder: decoder::Metadata,
}

impl<'a> FieldKind<'a> for PlanesField<'a> {
    const NAMES: &'static [Known] = &[
        Known { code: TABLE, text: "planes table", role: Role::Table, several: true },
        decoder::NAMES[0],
        decoder::NAMES[1],
        decoder::NAMES[2],
        decoder::NAMES[3],
    ];
    const MAX_TENSORS: usize = 2 * MAX_PAIRS + decoder::MAX_TENSORS;
    type Metadata = Metadata;

    fn read(mut fields: Fields<'a>) -> Result<Metadata, FormatError> {
        let planes: PlanesV1 = fields.take()?;
        fields.check("n_components", matches!(planes.n_components, 16 | 32))?;
        Ok(Metadata { planes, decoder: decoder::read(fields)? })
    }

    fn open(metadata: &Metadata, listed: &mut Listed<'a>) -> Result<Self, FormatError> {
        let PlanesV1 { resolution, n_components } = metadata.planes;
        let mut pairs = [Pair::EMPTY; MAX_PAIRS];
        let n_pairs = Planes::n_pairs(n_components);
        for (number, pair) in (0..).step_by(2).zip(&mut pairs[..n_pairs]) {
            pair.plane = listed.need(TensorName::new(TABLE, number))?;
            pair.line = listed.need(TensorName::new(TABLE, number + 1))?;
        }
        let decoder = decoder::open(&metadata.decoder, listed)?;
        Ok(Self { planes: Planes { resolution, n_components, pairs }, decoder })
    }

    fn metadata(&self) -> Option<Metadata> {
        let Planes { resolution, n_components, .. } = self.planes;
        let decoder = decoder::metadata(&self.decoder)?;
        Some(Metadata { planes: PlanesV1 { resolution, n_components }, decoder })
    }

    fn write<W: Extend<u8>>(metadata: &Metadata, bytes: W) -> Option<W> {
        decoder::write(&metadata.decoder, append(bytes, &metadata.planes)?)
    }

    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> {
        let n_pairs = Planes::n_pairs(self.planes.n_components).min(MAX_PAIRS);
        let tables = self.planes.pairs[..n_pairs].iter().flat_map(|pair| [pair.plane, pair.line]);
        let tables = (0..).zip(tables).map(|(n, table)| (TensorName::new(TABLE, n), table));
        tables.chain(decoder::tensors(&self.decoder))
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use pocketnerf_core::field::Shading;

    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::field::widths::Widths;
    use crate::metadata::test_section;

    fn widths(values: &[u32]) -> Widths {
        let mut widths = Widths::default();
        assert!(values.iter().all(|width| widths.push(*width)));
        widths
    }

    #[test]
    fn bytes_of_planes_v1() {
        let decoder = decoder::Metadata {
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
            log_density_bias: -2.0,
            density: widths(&[48, 64, 16]),
            color: widths(&[31, 3]),
        };
        let planes = PlanesV1 { resolution: 300, n_components: 16 };
        let metadata = Metadata { planes, decoder };
        let mut bytes = PlanesField::write(&metadata, Vec::new()).unwrap();
        let expected = [
            &[0xac, 0x02, 16][..],          // 300 entries along an axis, 16 components
            &[15, 4, 1, 0, 0, 0, 0xc0],     // features, degree, per ray, -2.0
            &[3, 48, 64, 16, 2, 31, 3][..], // both networks
        ];
        assert_eq!(bytes, expected.concat());
        let read = |bytes: &[u8]| {
            PlanesField::read(Fields::open(&test_section(kind::FIELD, bytes)).unwrap())
        };
        assert_eq!(read(&bytes), Ok(metadata));
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        bytes[2] = 24;
        assert_eq!(read(&bytes), Err(FormatError::Value { section, field: "n_components" }));
    }
}
