//! Hash grids: FIELD is the grid, then its decoder.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
use pocketnerf_core::field::HashGridField;
use serde::{Deserialize, Serialize};

use super::FieldKind;
#[cfg(feature = "corner-index")]
use super::corner_levels;
use super::decoder;
use crate::FormatError;
use crate::directory::Listed;
use crate::metadata::{Fields, append};
use crate::tensor_name::{Known, Role, TensorName};

/// Code of the tensors that are levels' tables.
const LEVEL: u8 = 0;
/// Code of [`GridIndex::Blocked`].
const BLOCKED: u8 = 0;

/// The grid. Where its entries are numbered by corner, its levels follow.
#[derive(Serialize, Deserialize)]
struct HashGridV1 {
    n_levels: u32,
    n_features_per_level: u32,
    log2_hashmap_size: u32,
    base_resolution: u32,
    per_level_scale: f32,
    index: u8,
}

/// What FIELD says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metadata {
    grid: HashGridConfig,
    decoder: decoder::Metadata,
}

impl<'a> FieldKind<'a> for HashGridField<'a> {
    const NAMES: &'static [Known] = &[
        Known { code: LEVEL, text: "grid level", role: Role::Table, several: true },
        decoder::NAMES[0],
        decoder::NAMES[1],
        decoder::NAMES[2],
        decoder::NAMES[3],
    ];
    const MAX_TENSORS: usize = MAX_LEVELS + decoder::MAX_TENSORS;
    type Metadata = Metadata;

    fn read(mut fields: Fields<'a>) -> Result<Metadata, FormatError> {
        let grid = read_grid(&mut fields)?;
        Ok(Metadata { grid, decoder: decoder::read(fields)? })
    }

    fn open(metadata: &Metadata, listed: &mut Listed<'a>) -> Result<Self, FormatError> {
        let config = metadata.grid;
        let levels = levels(config.n_levels, listed)?;
        let decoder = decoder::open(&metadata.decoder, listed)?;
        Ok(Self { grid: HashGrid { config, levels }, decoder })
    }

    fn metadata(&self) -> Option<Metadata> {
        Some(Metadata { grid: self.grid.config, decoder: decoder::metadata(&self.decoder)? })
    }

    fn write<W: Extend<u8>>(metadata: &Metadata, bytes: W) -> Option<W> {
        decoder::write(&metadata.decoder, write_grid(&metadata.grid, bytes)?)
    }

    fn tensors(&self) -> impl Iterator<Item = (TensorName, TensorView<'a>)> {
        let n_levels = (self.grid.config.n_levels as usize).min(MAX_LEVELS);
        let levels = (0..).zip(&self.grid.levels[..n_levels]);
        let levels = levels.map(|(l, table)| (TensorName::new(LEVEL, l), *table));
        levels.chain(decoder::tensors(&self.decoder))
    }
}

/// The tables of a grid of so many levels.
// Not inlined: smaller on a bare target.
#[inline(never)]
fn levels<'a>(
    n_levels: u32,
    listed: &mut Listed<'a>,
) -> Result<[TensorView<'a>; MAX_LEVELS], FormatError> {
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    for (l, level) in (0..n_levels).zip(&mut levels) {
        *level = listed.need(TensorName::new(LEVEL, l))?;
    }
    Ok(levels)
}

fn read_grid(fields: &mut Fields<'_>) -> Result<HashGridConfig, FormatError> {
    let grid: HashGridV1 = fields.take()?;
    fields.finite("per_level_scale", &[grid.per_level_scale])?;
    Ok(HashGridConfig {
        n_levels: grid.n_levels,
        n_features_per_level: grid.n_features_per_level,
        log2_hashmap_size: grid.log2_hashmap_size,
        base_resolution: grid.base_resolution,
        per_level_scale: grid.per_level_scale,
        index: match grid.index {
            BLOCKED => GridIndex::Blocked,
            #[cfg(feature = "corner-index")]
            corner_levels::CODE => GridIndex::Corners(corner_levels::read(fields, grid.n_levels)?),
            code => return Err(fields.unknown("index of grid entries", code)),
        },
    })
}

fn write_grid<W: Extend<u8>>(grid: &HashGridConfig, bytes: W) -> Option<W> {
    let v1 = |index| HashGridV1 {
        n_levels: grid.n_levels,
        n_features_per_level: grid.n_features_per_level,
        log2_hashmap_size: grid.log2_hashmap_size,
        base_resolution: grid.base_resolution,
        per_level_scale: grid.per_level_scale,
        index,
    };
    match &grid.index {
        GridIndex::Blocked => append(bytes, &v1(BLOCKED)),
        #[cfg(feature = "corner-index")]
        GridIndex::Corners(corners) => {
            let bytes = append(bytes, &v1(corner_levels::CODE))?;
            corner_levels::write(corners, grid.n_levels, bytes)
        }
        _ => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
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

    pub(crate) fn decoder() -> decoder::Metadata {
        decoder::Metadata {
            n_features: 15,
            sh_degree: 4,
            shading: Shading::PerRay,
            log_density_bias: -2.0,
            density: widths(&[32, 64, 16]),
            color: widths(&[31, 3]),
        }
    }

    pub(crate) fn read(bytes: &[u8]) -> Result<Metadata, FormatError> {
        HashGridField::read(Fields::open(&test_section(kind::FIELD, bytes))?)
    }

    pub(crate) const BYTES: [u8; 24] = [
        8, 4, 17, 0xac, 0x02, // 300 as a varint
        0, 0, 0xc0, 0x3f, // 1.5
        0,    // index: blocked
        15, 4, 1, 0, 0, 0, 0xc0, // features, degree, per ray, -2.0
        3, 32, 64, 16, // density network
        2, 31, 3, // colour network
    ];

    pub(crate) const GRID: HashGridConfig = HashGridConfig {
        n_levels: 8,
        n_features_per_level: 4,
        log2_hashmap_size: 17,
        base_resolution: 300,
        per_level_scale: 1.5,
        index: GridIndex::Blocked,
    };

    #[test]
    fn bytes_of_hash_grid_v1() {
        let metadata = Metadata { grid: GRID, decoder: decoder() };
        let mut bytes = HashGridField::write(&metadata, Vec::new()).unwrap();
        assert_eq!(bytes, BYTES);
        assert_eq!(read(&bytes), Ok(metadata));
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), Err(FormatError::Metadata(section)));
        }
        bytes[9] = 7;
        let field = "index of grid entries";
        assert_eq!(read(&bytes), Err(FormatError::UnknownCode { section, field, found: 7 }));
    }

    #[cfg(feature = "corner-index")]
    #[test]
    fn corner_levels_follow_the_grid() {
        use pocketnerf_core::encoding::CornerLevels;

        let levels = CornerLevels { shift: 0.5, levels: Default::default() };
        let grid = HashGridConfig { n_levels: 1, index: GridIndex::Corners(levels), ..GRID };
        let metadata = Metadata { grid, decoder: decoder() };
        let bytes = HashGridField::write(&metadata, Vec::new()).unwrap();
        let mut expected = BYTES.to_vec();
        (expected[0], expected[9]) = (1, 1);
        expected.splice(10..10, [0, 0, 0, 0x3f, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes, expected);
        assert_eq!(read(&bytes), Ok(metadata));
    }
}
