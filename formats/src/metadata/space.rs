//! SPACE, SAMPLING, HIERARCHICAL and OCCUPANCY: the geometry of a ray's way.

use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::{Sampling, Space};
use serde::{Deserialize, Serialize};

#[cfg(feature = "contracted")]
use super::contracted;
#[cfg(feature = "ndc")]
use super::ndc;
use super::{Fields, append};
use crate::FormatError;

/// Code of a box in SPACE.
const BOX: u8 = 0;

/// Code of normalised device coordinates.
const NDC: u8 = 1;

/// Code of contracted space.
const CONTRACTED: u8 = 2;

/// SPACE after its code, kind [`BOX`]. Scene units.
#[derive(Serialize, Deserialize)]
pub(crate) struct BoxV1 {
    min: [f32; 3],
    max: [f32; 3],
}

pub(crate) fn read_space(mut fields: Fields<'_>) -> Result<Space, FormatError> {
    let space = match fields.take::<u8>()? {
        BOX => {
            let BoxV1 { min, max } = fields.take()?;
            fields.finite("min", &min)?;
            fields.finite("max", &max)?;
            Space::Box { min, max }
        }
        #[cfg(feature = "ndc")]
        NDC => Space::Ndc(ndc::read(&mut fields)?),
        #[cfg(feature = "contracted")]
        CONTRACTED => Space::Contracted(contracted::read(&mut fields)?),
        code if code == CONTRACTED => return Err(FormatError::SpaceKind("contracted")),
        code if code == NDC => return Err(FormatError::SpaceKind("ndc")),
        code => return Err(fields.unknown("kind of space", code)),
    };
    fields.finish()?;
    Ok(space)
}

/// Appends SPACE; `None` for a space that the format has no code for.
pub(crate) fn write_space<W: Extend<u8>>(space: &Space, bytes: W) -> Option<W> {
    match *space {
        Space::Box { min, max } => append(bytes, &(BOX, BoxV1 { min, max })),
        #[cfg(feature = "ndc")]
        Space::Ndc(ndc) => append(bytes, &(NDC, ndc::write(ndc))),
        #[cfg(feature = "contracted")]
        Space::Contracted(space) => append(bytes, &(CONTRACTED, contracted::write(space))),
        _ => None,
    }
}

/// SAMPLING. Local units of the space: of a box, scene units.
#[derive(Serialize, Deserialize)]
pub(crate) struct SamplingV1 {
    step: f32,
    near: f32,
    far: f32,
    min_transmittance: f32,
}

pub(crate) fn read_sampling(mut fields: Fields<'_>) -> Result<Sampling, FormatError> {
    let SamplingV1 { step, near, far, min_transmittance } = fields.take()?;
    fields.finite("step", &[step])?;
    fields.finite("near", &[near])?;
    fields.finite("far", &[far])?;
    fields.finite("min_transmittance", &[min_transmittance])?;
    fields.finish()?;
    Ok(Sampling { step, near, far, min_transmittance })
}

pub(crate) fn write_sampling(sampling: &Sampling) -> impl Serialize {
    let Sampling { step, near, far, min_transmittance } = *sampling;
    SamplingV1 { step, near, far, min_transmittance }
}

/// HIERARCHICAL; the fields are those of [`Hierarchical`].
#[derive(Serialize, Deserialize)]
struct HierarchicalV1 {
    reach: u8,
    n_coarse: u32,
    n_fine: u32,
}

pub(crate) fn read_hierarchical(mut fields: Fields<'_>) -> Result<Hierarchical, FormatError> {
    let HierarchicalV1 { reach: code, n_coarse, n_fine } = fields.take()?;
    let reach = match code {
        0 => Reach::Distance,
        1 => Reach::Clipped,
        2 => Reach::Depth,
        _ => return Err(fields.unknown("reach", code)),
    };
    fields.finish()?;
    Ok(Hierarchical { n_coarse, n_fine, reach })
}

pub(crate) fn write_hierarchical(hierarchical: &Hierarchical) -> impl Serialize {
    let Hierarchical { n_coarse, n_fine, reach } = *hierarchical;
    let reach = match reach {
        Reach::Distance => 0,
        Reach::Clipped => 1,
        Reach::Depth => 2,
    };
    HierarchicalV1 { reach, n_coarse, n_fine }
}

/// OCCUPANCY.
#[derive(Serialize, Deserialize)]
pub(crate) struct OccupancyV1 {
    /// Cells along an axis.
    pub(crate) resolution: u32,
    pub(crate) n_cascades: u32,
}

pub(crate) fn read_occupancy(mut fields: Fields<'_>) -> Result<OccupancyV1, FormatError> {
    let occupancy = fields.take()?;
    fields.finish()?;
    Ok(occupancy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::{encode, test_section};

    fn fields(kind: u32, bytes: &[u8]) -> Fields<'_> {
        Fields::open(&test_section(kind, bytes)).unwrap()
    }

    #[test]
    fn bytes_of_space_v1() {
        let space = Space::Box { min: [-1.0, 0.5, 2.0], max: [1.0, 4.0, 8.0] };
        let bytes = write_space(&space, alloc::vec::Vec::new()).unwrap();
        #[rustfmt::skip]
        let golden = [
            0,
            0, 0, 0x80, 0xbf,  0, 0, 0, 0x3f,     0, 0, 0, 0x40,
            0, 0, 0x80, 0x3f,  0, 0, 0x80, 0x40,  0, 0, 0, 0x41,
        ];
        assert_eq!(bytes, golden);
        assert_eq!(read_space(fields(kind::SPACE, &bytes)), Ok(space));
        let section = SectionId::first(kind::SPACE);
        assert_eq!(
            read_space(fields(kind::SPACE, &[9])),
            Err(FormatError::UnknownCode { section, field: "kind of space", found: 9 })
        );
        let mut long = bytes;
        long.push(0);
        assert_eq!(read_space(fields(kind::SPACE, &long)), Err(FormatError::Metadata(section)));
    }

    #[test]
    fn a_space_that_is_left_out_is_refused_by_name() {
        for (code, name, is_there) in [
            (NDC, "ndc", cfg!(feature = "ndc")),
            (CONTRACTED, "contracted", cfg!(feature = "contracted")),
        ] {
            let error = read_space(fields(kind::SPACE, &[code])).unwrap_err();
            assert_eq!(error == FormatError::SpaceKind(name), !is_there);
        }
    }

    #[test]
    fn bytes_of_sampling_v1() {
        let sampling = Sampling { step: 0.5, near: 1.0, far: 2.0, min_transmittance: 0.25 };
        let bytes = encode(&write_sampling(&sampling));
        assert_eq!(bytes, [0, 0, 0, 0x3f, 0, 0, 0x80, 0x3f, 0, 0, 0, 0x40, 0, 0, 0x80, 0x3e]);
        assert_eq!(read_sampling(fields(kind::SAMPLING, &bytes)), Ok(sampling));
        let bad = encode(&write_sampling(&Sampling { far: f32::INFINITY, ..sampling }));
        let section = SectionId::first(kind::SAMPLING);
        assert_eq!(
            read_sampling(fields(kind::SAMPLING, &bad)),
            Err(FormatError::Value { section, field: "far" })
        );
    }

    #[test]
    fn bytes_of_hierarchical_v1() {
        let hierarchical = Hierarchical { reach: Reach::Clipped, ..Hierarchical::PAPER };
        let bytes = encode(&write_hierarchical(&hierarchical));
        assert_eq!(bytes, [1, 64, 0x80, 1]);
        let read = |bytes: &[u8]| read_hierarchical(fields(kind::HIERARCHICAL, bytes));
        assert_eq!(read(&bytes), Ok(hierarchical));
        let error = FormatError::Metadata(SectionId::first(kind::HIERARCHICAL));
        for (code, reach) in [(0, Reach::Distance), (2, Reach::Depth)] {
            let hierarchical = Hierarchical { reach, ..hierarchical };
            assert_eq!(encode(&write_hierarchical(&hierarchical)), [code, 64, 0x80, 1]);
            assert_eq!(read(&[code, 64, 0x80, 1]), Ok(hierarchical));
        }
        let section = SectionId::first(kind::HIERARCHICAL);
        let unknown = FormatError::UnknownCode { section, field: "reach", found: 3 };
        assert_eq!(read(&[3, 64, 64]), Err(unknown));
        assert_eq!(read(&[1, 64]), Err(error));
    }

    #[test]
    fn bytes_of_occupancy_v1() {
        let bytes = encode(&OccupancyV1 { resolution: 128, n_cascades: 1 });
        assert_eq!(bytes, [0x80, 1, 1]);
        assert_eq!(read_occupancy(fields(kind::OCCUPANCY, &bytes)).unwrap().resolution, 128);
    }
}
