//! FIELD: the kind of field and its configuration, without weights.

#[cfg(feature = "frequency")]
use pocketnerf_core::encoding::FrequencyConfig;
#[cfg(feature = "hash-grid")]
use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use pocketnerf_core::field::Shading;
use serde::{Deserialize, Serialize};

use super::Fields;
use super::widths::Widths;
use crate::FormatError;

/// Codes of the field kinds.
const HASH_GRID: u8 = 0;
const FREQUENCY: u8 = 1;
/// Code of [`GridIndex::Blocked`].
#[cfg(feature = "hash-grid")]
const BLOCKED: u8 = 0;
/// Codes of [`Shading`].
const PER_SAMPLE: u8 = 0;
const PER_RAY: u8 = 1;

/// FIELD after its code, kind [`HASH_GRID`]; a [`DecoderV1`] follows.
#[cfg(feature = "hash-grid")]
#[derive(Serialize, Deserialize)]
struct HashGridV1 {
    n_levels: u32,
    n_features_per_level: u32,
    log2_hashmap_size: u32,
    base_resolution: u32,
    per_level_scale: f32,
    index: u8,
}

/// FIELD after its code, kind [`FREQUENCY`]; a [`DecoderV1`] follows.
#[cfg(feature = "frequency")]
#[derive(Serialize, Deserialize)]
struct FrequencyV1 {
    n_frequencies: u32,
    include_input: bool,
}

/// The end of FIELD.
#[derive(Serialize, Deserialize)]
struct DecoderV1 {
    n_features: u32,
    sh_degree: u32,
    shading: u8,
    log_density_bias: f32,
    density: Widths,
    color: Widths,
}

/// What FIELD says of the position encoding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum EncodingConfig {
    #[cfg(feature = "hash-grid")]
    HashGrid(HashGridConfig),
    #[cfg(feature = "frequency")]
    Frequency(FrequencyConfig),
}

/// What FIELD says of the decoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DecoderConfig {
    pub(crate) n_features: u32,
    pub(crate) sh_degree: u32,
    pub(crate) shading: Shading,
    pub(crate) log_density_bias: f32,
    pub(crate) density: Widths,
    pub(crate) color: Widths,
}

pub(crate) fn read_field(
    mut fields: Fields<'_>,
) -> Result<(EncodingConfig, DecoderConfig), FormatError> {
    let encoding = match fields.take::<u8>()? {
        #[cfg(feature = "hash-grid")]
        HASH_GRID => {
            let grid: HashGridV1 = fields.take()?;
            fields.finite("per_level_scale", &[grid.per_level_scale])?;
            EncodingConfig::HashGrid(HashGridConfig {
                n_levels: grid.n_levels,
                n_features_per_level: grid.n_features_per_level,
                log2_hashmap_size: grid.log2_hashmap_size,
                base_resolution: grid.base_resolution,
                per_level_scale: grid.per_level_scale,
                index: match grid.index {
                    BLOCKED => GridIndex::Blocked,
                    code => return Err(fields.unknown("index of grid entries", code)),
                },
            })
        }
        #[cfg(feature = "frequency")]
        FREQUENCY => {
            let FrequencyV1 { n_frequencies, include_input } = fields.take()?;
            EncodingConfig::Frequency(FrequencyConfig { n_frequencies, include_input })
        }
        #[cfg(not(feature = "hash-grid"))]
        HASH_GRID => return Err(FormatError::FieldKind("hash-grid")),
        #[cfg(not(feature = "frequency"))]
        FREQUENCY => return Err(FormatError::FieldKind("frequency")),
        code => return Err(fields.unknown("kind of field", code)),
    };
    let decoder: DecoderV1 = fields.take()?;
    fields.finite("log_density_bias", &[decoder.log_density_bias])?;
    let shading = match decoder.shading {
        PER_SAMPLE => Shading::PerSample,
        PER_RAY => Shading::PerRay,
        code => return Err(fields.unknown("shading", code)),
    };
    fields.finish()?;
    let DecoderV1 { n_features, sh_degree, log_density_bias, density, color, .. } = decoder;
    let decoder =
        DecoderConfig { n_features, sh_degree, shading, log_density_bias, density, color };
    Ok((encoding, decoder))
}

/// The section's bytes; `None` for a choice that the format has no code for.
#[cfg(feature = "alloc")]
pub(crate) fn write_field(
    encoding: &EncodingConfig,
    decoder: &DecoderConfig,
) -> Option<alloc::vec::Vec<u8>> {
    let decoder = DecoderV1 {
        n_features: decoder.n_features,
        sh_degree: decoder.sh_degree,
        shading: match decoder.shading {
            Shading::PerSample => PER_SAMPLE,
            Shading::PerRay => PER_RAY,
        },
        log_density_bias: decoder.log_density_bias,
        density: decoder.density,
        color: decoder.color,
    };
    Some(match *encoding {
        #[cfg(feature = "hash-grid")]
        EncodingConfig::HashGrid(grid) => {
            let index = match grid.index {
                GridIndex::Blocked => BLOCKED,
                _ => return None,
            };
            let grid = HashGridV1 {
                n_levels: grid.n_levels,
                n_features_per_level: grid.n_features_per_level,
                log2_hashmap_size: grid.log2_hashmap_size,
                base_resolution: grid.base_resolution,
                per_level_scale: grid.per_level_scale,
                index,
            };
            super::encode(&(HASH_GRID, grid, decoder))
        }
        #[cfg(feature = "frequency")]
        EncodingConfig::Frequency(FrequencyConfig { n_frequencies, include_input }) => {
            super::encode(&(FREQUENCY, FrequencyV1 { n_frequencies, include_input }, decoder))
        }
    })
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;
    use crate::metadata::test_section;
    use crate::section::{SectionId, kind};

    fn widths(values: &[u32]) -> Widths {
        let mut widths = Widths::default();
        assert!(values.iter().all(|width| widths.push(*width)));
        widths
    }

    fn decoder() -> DecoderConfig {
        DecoderConfig {
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
            log_density_bias: -2.0,
            density: widths(&[32, 64, 16]),
            color: widths(&[31, 3]),
        }
    }

    fn read(bytes: &[u8]) -> Result<(EncodingConfig, DecoderConfig), FormatError> {
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
    const FREQUENCY_BYTES: [u8; 17] = [1, 10, 1, 15, 4, 1, 0, 0, 0, 0xc0, 3, 32, 64, 16, 2, 31, 3];

    #[cfg(feature = "hash-grid")]
    #[test]
    fn bytes_of_hash_grid_v1() {
        let encoding = EncodingConfig::HashGrid(HashGridConfig {
            n_levels: 8,
            n_features_per_level: 4,
            log2_hashmap_size: 17,
            base_resolution: 300,
            per_level_scale: 1.5,
            index: GridIndex::Blocked,
        });
        let mut bytes = write_field(&encoding, &decoder()).unwrap();
        assert_eq!(bytes, HASH_GRID_BYTES);
        assert_eq!(read(&bytes), Ok((encoding, decoder())));
        bytes[10] = 7;
        let section = SectionId::first(kind::FIELD);
        assert_eq!(
            read(&bytes),
            Err(FormatError::UnknownCode { section, field: "index of grid entries", found: 7 })
        );
    }

    #[cfg(feature = "frequency")]
    #[test]
    fn bytes_of_frequency_v1() {
        let encoding =
            EncodingConfig::Frequency(FrequencyConfig { n_frequencies: 10, include_input: true });
        let bytes = write_field(&encoding, &decoder()).unwrap();
        assert_eq!(bytes, FREQUENCY_BYTES);
        assert_eq!(read(&bytes), Ok((encoding, decoder())));
        for end in 0..bytes.len() {
            assert_eq!(
                read(&bytes[..end]),
                Err(FormatError::Metadata(SectionId::first(kind::FIELD)))
            );
        }
    }

    #[test]
    fn a_kind_that_is_left_out_is_refused_by_name() {
        for (bytes, kind, linked) in [
            (&HASH_GRID_BYTES[..], "hash-grid", cfg!(feature = "hash-grid")),
            (&FREQUENCY_BYTES[..], "frequency", cfg!(feature = "frequency")),
        ] {
            match read(bytes) {
                Ok(_) => assert!(linked),
                Err(error) => assert_eq!((error, linked), (FormatError::FieldKind(kind), false)),
            }
        }
    }
}
