//! The levels of a hash grid whose corners are numbered one by one, in FIELD after the grid.

use pocketnerf_core::encoding::{CornerLevel, CornerLevels, MAX_LEVELS};
use serde::{Deserialize, Serialize};

use crate::FormatError;
use crate::metadata::{Fields, append};

/// Code of this index of grid entries.
pub(crate) const CODE: u8 = 1;

/// A level. Their common shift (`f32`) precedes the first one.
#[derive(Serialize, Deserialize)]
struct CornerLevelV1 {
    scale: f32,
    side: u32,
    entries: u32,
}

pub(crate) fn read(fields: &mut Fields<'_>, n_levels: u32) -> Result<CornerLevels, FormatError> {
    let mut levels = [CornerLevel::default(); MAX_LEVELS];
    fields.check("n_levels", n_levels as usize <= MAX_LEVELS)?;
    let shift = fields.take()?;
    for level in &mut levels[..n_levels as usize] {
        let CornerLevelV1 { scale, side, entries } = fields.take()?;
        *level = CornerLevel { scale, side, entries };
    }
    Ok(CornerLevels { shift, levels })
}

pub(crate) fn write<W: Extend<u8>>(corners: &CornerLevels, n_levels: u32, bytes: W) -> Option<W> {
    let mut levels = corners.levels.iter().take(n_levels as usize);
    levels.try_fold(append(bytes, &corners.shift)?, |bytes, level| {
        let &CornerLevel { scale, side, entries } = level;
        append(bytes, &CornerLevelV1 { scale, side, entries })
    })
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::test_section;

    fn read_all(bytes: &[u8], n_levels: u32) -> Result<CornerLevels, FormatError> {
        let mut fields = Fields::open(&test_section(kind::FIELD, bytes))?;
        let levels = read(&mut fields, n_levels)?;
        fields.finish()?;
        Ok(levels)
    }

    #[test]
    fn bytes_of_corner_levels() {
        let mut levels = [CornerLevel::default(); MAX_LEVELS];
        levels[0] = CornerLevel { scale: 1.5, side: 300, entries: 7 };
        let corners = CornerLevels { shift: 0.5, levels };
        let bytes = write(&corners, 2, Vec::new()).unwrap();
        let expected = [
            &[0, 0, 0, 0x3f][..],               // shift 0.5
            &[0, 0, 0xc0, 0x3f, 0xac, 0x02, 7], // 1.5, 300, 7
            &[0, 0, 0, 0, 0, 0],                // the second level: zeros
        ];
        assert_eq!(bytes, expected.concat());
        assert_eq!(read_all(&bytes, 2), Ok(corners));
        let section = SectionId::first(kind::FIELD);
        for end in 0..bytes.len() {
            assert_eq!(read_all(&bytes[..end], 2), Err(FormatError::Metadata(section)));
        }
        // More levels than there can be.
        let error = FormatError::Value { section, field: "n_levels" };
        assert_eq!(read_all(&bytes, 17), Err(error));
    }
}
