//! FIELD: the kind of field and its configuration, without weights.

#[cfg(feature = "hash-grid")]
use pocketnerf_core::encoding::HashGridConfig;

use super::Fields;
#[cfg(all(feature = "alloc", feature = "hash-grid"))]
use super::decoder::DecoderV1;
#[cfg(feature = "hash-grid")]
use super::decoder::{DecoderConfig, read_decoder};
#[cfg(feature = "nerf")]
use super::nerf::NerfV1;
use crate::FormatError;

/// Codes of the field kinds.
const HASH_GRID: u8 = 0;
// 1 is reserved: no kind has it.
const NERF: u8 = 2;

/// What FIELD says, by kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FieldConfig {
    #[cfg(feature = "hash-grid")]
    HashGrid(HashGridConfig, DecoderConfig),
    #[cfg(feature = "nerf")]
    Nerf(NerfV1),
}

pub(crate) fn read_field(mut fields: Fields<'_>) -> Result<FieldConfig, FormatError> {
    match fields.take::<u8>()? {
        #[cfg(feature = "hash-grid")]
        HASH_GRID => {
            let config = super::hash_grid::read(&mut fields)?;
            Ok(FieldConfig::HashGrid(config, read_decoder(fields)?))
        }
        #[cfg(feature = "nerf")]
        NERF => Ok(FieldConfig::Nerf(NerfV1::read(fields)?)),
        #[cfg(not(feature = "hash-grid"))]
        HASH_GRID => Err(FormatError::FieldKind("hash-grid")),
        #[cfg(not(feature = "nerf"))]
        NERF => Err(FormatError::FieldKind("nerf")),
        code => Err(fields.unknown("kind of field", code)),
    }
}

/// The section's bytes; `None` for a choice that the format has no code for.
#[cfg(feature = "alloc")]
pub(crate) fn write_field(config: &FieldConfig) -> Option<alloc::vec::Vec<u8>> {
    Some(match config {
        #[cfg(feature = "hash-grid")]
        FieldConfig::HashGrid(grid, decoder) => {
            let grid = super::hash_grid::write(grid)?;
            [super::encode(&HASH_GRID), grid, super::encode(&DecoderV1::of(decoder))].concat()
        }
        #[cfg(feature = "nerf")]
        FieldConfig::Nerf(nerf) => super::encode(&(NERF, nerf)),
    })
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;
    use crate::metadata::test_section;
    use crate::section::kind;

    #[cfg(feature = "hash-grid")]
    fn widths(values: &[u32]) -> crate::metadata::widths::Widths {
        let mut widths = crate::metadata::widths::Widths::default();
        assert!(values.iter().all(|width| widths.push(*width)));
        widths
    }

    #[cfg(feature = "hash-grid")]
    fn decoder() -> DecoderConfig {
        DecoderConfig {
            n_features: 15,
            sh_degree: 4,
            shading: pocketnerf_core::field::Shading::PerRay,
            log_density_bias: -2.0,
            density: widths(&[32, 64, 16]),
            color: widths(&[31, 3]),
        }
    }

    fn read(bytes: &[u8]) -> Result<FieldConfig, FormatError> {
        read_field(Fields::open(&test_section(kind::FIELD, bytes))?)
    }

    /// FIELD of each kind.
    const HASH_GRID_BYTES: [u8; 25] = [
        0, // kind: hash grid
        8, 4, 17, 0xac, 0x02, // 300 as a varint
        0, 0, 0xc0, 0x3f, // 1.5
        0,    // index: blocked
        15, 4, 1, 0, 0, 0, 0xc0, // features, degree, per ray, -2.0
        3, 32, 64, 16, // density network
        2, 31, 3, // colour network
    ];
    /// One octave, no directions, one layer of eight.
    #[rustfmt::skip]
    const NERF_BYTES: [u8; 45] = [
        2,
        0, 1, 0, 0,  0,
        0, 0, 0x80, 0x3f,  0, 0, 0x80, 0x3f,  0, 0, 0x80, 0x3f,
        0, 0, 0, 0,        0, 0, 0, 0,        0, 0, 0, 0,
        0,  0, 0, 0x80, 0x3f,
        2, 6, 8,  0, 0,  0,  2, 8, 3,
        0,
    ];

    #[cfg(feature = "hash-grid")]
    const HASH_GRID_CONFIG: HashGridConfig = HashGridConfig {
        n_levels: 8,
        n_features_per_level: 4,
        log2_hashmap_size: 17,
        base_resolution: 300,
        per_level_scale: 1.5,
        index: pocketnerf_core::encoding::GridIndex::Blocked,
    };

    #[cfg(feature = "hash-grid")]
    #[test]
    fn bytes_of_hash_grid_v1() {
        let config = FieldConfig::HashGrid(HASH_GRID_CONFIG, decoder());
        let mut bytes = write_field(&config).unwrap();
        assert_eq!(bytes, HASH_GRID_BYTES);
        assert_eq!(read(&bytes), Ok(config));
        for end in 0..bytes.len() {
            let section = crate::section::SectionId::first(kind::FIELD);
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        bytes[10] = 7;
        let section = crate::section::SectionId::first(kind::FIELD);
        assert_eq!(
            read(&bytes),
            Err(FormatError::UnknownCode { section, field: "index of grid entries", found: 7 })
        );
    }

    #[cfg(feature = "corner-index")]
    #[test]
    fn bytes_of_corner_levels() {
        use pocketnerf_core::encoding::{CornerLevel, CornerLevels, GridIndex, MAX_LEVELS};

        let mut levels = [CornerLevel::default(); MAX_LEVELS];
        levels[0] = CornerLevel { scale: 1.5, side: 300, entries: 7 };
        let index = GridIndex::Corners(CornerLevels { shift: 0.5, levels });
        let grid = HashGridConfig { n_levels: 2, index, ..HASH_GRID_CONFIG };
        let config = FieldConfig::HashGrid(grid, decoder());
        let bytes = write_field(&config).unwrap();
        let mut expected = HASH_GRID_BYTES.to_vec();
        (expected[1], expected[10]) = (2, 1);
        let inserted = [
            &[0, 0, 0, 0x3f][..],               // shift 0.5
            &[0, 0, 0xc0, 0x3f, 0xac, 0x02, 7], // 1.5, 300, 7
            &[0, 0, 0, 0, 0, 0],                // the second level: zeros
        ];
        expected.splice(11..11, inserted.concat());
        assert_eq!(bytes, expected);
        assert_eq!(read(&bytes), Ok(config));
        // More levels than there can be.
        expected[1] = 17;
        let section = crate::section::SectionId::first(kind::FIELD);
        assert_eq!(read(&expected), Err(FormatError::Value { section, field: "n_levels" }));
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
    }

    #[test]
    fn a_reserved_code_is_no_kind() {
        let section = crate::section::SectionId::first(kind::FIELD);
        let unknown = FormatError::UnknownCode { section, field: "kind of field", found: 1 };
        assert_eq!(read(&[1, 10, 1]), Err(unknown));
    }

    #[test]
    fn a_kind_that_is_left_out_is_refused_by_name() {
        for (bytes, kind, linked) in [
            (&HASH_GRID_BYTES[..], "hash-grid", cfg!(feature = "hash-grid")),
            (&NERF_BYTES[..], "nerf", cfg!(feature = "nerf")),
        ] {
            match read(bytes) {
                Ok(_) => assert!(linked),
                Err(error) => assert_eq!((error, linked), (FormatError::FieldKind(kind), false)),
            }
        }
    }
}
