//! The model file that is linked into the program.

use pocketnerf_formats::{FormatError, ModelFile};

/// A hash grid of two levels in half precision, read where it lies.
// A section of its own: code size is measured without the model.
#[cfg_attr(target_os = "none", unsafe(link_section = ".model"))]
static BYTES: [u8; 4352] = *include_bytes!("../../golden/hash-grid-f16.pnerf");

/// The model that the bytes hold.
pub(crate) fn open() -> Result<ModelFile<'static>, FormatError> {
    // Not a constant to the optimiser, or it would read while compiling.
    pocketnerf_formats::open(core::hint::black_box(&BYTES))
}
