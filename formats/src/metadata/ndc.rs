//! SPACE of forward-facing captures, after its code.

use pocketnerf_core::space::Ndc;
use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;

/// The near plane in scene units; the box in normalised device coordinates.
#[derive(Serialize, Deserialize)]
struct NdcV1 {
    near: f32,
    slope: [f32; 2],
    min: [f32; 3],
    max: [f32; 3],
}

pub(crate) fn read(fields: &mut Fields<'_>) -> Result<Ndc, FormatError> {
    let NdcV1 { near, slope, min, max } = fields.take()?;
    fields.finite("near", &[near])?;
    fields.finite("slope", &slope)?;
    fields.finite("min", &min)?;
    fields.finite("max", &max)?;
    Ok(Ndc { near, slope, min, max })
}

pub(crate) fn write(ndc: Ndc) -> impl Serialize {
    let Ndc { near, slope, min, max } = ndc;
    NdcV1 { near, slope, min, max }
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
    const BYTES: [u8; 37] = [
        1,
        0, 0, 0x80, 0x3f,
        0, 0, 0xc0, 0x3f,  0, 0, 0, 0x40,
        0, 0, 0xc0, 0xbf,  0, 0, 0, 0xc0,     0, 0, 0x80, 0xbf,
        0, 0, 0xc0, 0x3f,  0, 0, 0, 0x40,     0, 0, 0x80, 0x3f,
    ];

    fn read(bytes: &[u8]) -> Result<Space, FormatError> {
        read_space(Fields::open(&test_section(kind::SPACE, bytes)).unwrap())
    }

    #[test]
    fn bytes_of_ndc_v1() {
        let (min, max) = ([-1.5, -2.0, -1.0], [1.5, 2.0, 1.0]);
        let space = Space::Ndc(Ndc { near: 1.0, slope: [1.5, 2.0], min, max });
        assert_eq!(write_space(&space, Vec::new()).unwrap(), BYTES);
        assert_eq!(read(&BYTES), Ok(space));
        let mut bad = BYTES;
        bad[3..5].copy_from_slice(&[0xc0, 0x7f]);
        let section = SectionId::first(kind::SPACE);
        assert_eq!(read(&bad), Err(FormatError::Value { section, field: "near" }));
        assert_eq!(read(&BYTES[..36]), Err(FormatError::Metadata(section)));
    }
}
