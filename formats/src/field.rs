//! From FIELD and TENSORS to a field.

use pocketnerf_core::AnyField;
#[cfg(feature = "hash-grid")]
use pocketnerf_core::encoding::HashGrid;
#[cfg(feature = "hash-grid")]
use pocketnerf_core::field::HashGridField;

use crate::FormatError;
#[cfg(feature = "hash-grid")]
use crate::decoded;
use crate::directory::Listed;
use crate::metadata::field::FieldConfig;
#[cfg(feature = "nerf")]
use crate::nerf;

/// The field that FIELD describes, of the listed tensors and no others.
// Not inlined, like [`decoded::levels`]: on a bare target that is a kilobyte less.
#[inline(never)]
pub(crate) fn read<'a>(
    config: &FieldConfig,
    mut listed: Listed<'a>,
) -> Result<AnyField<'a>, FormatError> {
    let field = match config {
        #[cfg(feature = "hash-grid")]
        FieldConfig::HashGrid(config, decoder) => {
            let levels = decoded::levels(config.n_levels, &mut listed)?;
            let decoder = decoded::decoder(decoder, &mut listed)?;
            AnyField::HashGrid(HashGridField {
                grid: HashGrid { config: *config, levels },
                decoder,
            })
        }
        #[cfg(feature = "nerf")]
        FieldConfig::Nerf(config) => AnyField::Nerf(nerf::read(config, &mut listed)?),
    };
    listed.finish()?;
    Ok(field)
}
