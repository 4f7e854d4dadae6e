//! SPACE of scenes without an end, after its code.

use pocketnerf_core::space::Contracted;
use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;

/// The cube that keeps its shape, scene units.
#[derive(Serialize, Deserialize)]
struct ContractedV1 {
    center: [f32; 3],
    radius: f32,
}

pub(crate) fn read(fields: &mut Fields<'_>) -> Result<Contracted, FormatError> {
    let ContractedV1 { center, radius } = fields.take()?;
    fields.finite("center", &center)?;
    fields.finite("radius", &[radius])?;
    Ok(Contracted { center, radius })
}

pub(crate) fn write(space: Contracted) -> impl Serialize {
    let Contracted { center, radius } = space;
    ContractedV1 { center, radius }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use pocketnerf_core::Space;

    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::space::{read_space, write_space};
    use crate::metadata::test_section;

    #[rustfmt::skip]
    const BYTES: [u8; 17] = [
        2,
        0, 0, 0x80, 0x3f,  0, 0, 0xc0, 0xbf,  0, 0, 0, 0x40,
        0, 0, 0x80, 0x40,
    ];

    fn read(bytes: &[u8]) -> Result<Space, FormatError> {
        read_space(Fields::open(&test_section(kind::SPACE, bytes)).unwrap())
    }

    #[test]
    fn bytes_of_contracted_v1() {
        let space = Space::Contracted(Contracted { center: [1.0, -1.5, 2.0], radius: 4.0 });
        assert_eq!(write_space(&space, Vec::new()).unwrap(), BYTES);
        assert_eq!(read(&BYTES), Ok(space));
        let mut bad = BYTES;
        bad[15..17].copy_from_slice(&[0xc0, 0x7f]);
        let section = SectionId::first(kind::SPACE);
        assert_eq!(read(&bad), Err(FormatError::Value { section, field: "radius" }));
        assert_eq!(read(&BYTES[..16]), Err(FormatError::Metadata(section)));
    }
}
