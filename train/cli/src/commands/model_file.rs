//! Model files: read, unpacked and opened.

use std::ops::Deref;
use std::path::Path;

use pocketnerf_formats::{ModelFile, is_packed, open_verified, unpacked_len};

use super::baseline_file::refuse_baseline;
use super::{Failure, memory};

/// A model file in memory, unpacked; or another program's file, as it is.
#[derive(Debug)]
pub(super) struct ModelBytes {
    bytes: Vec<u8>,
    /// The bytes of the file itself, where it is packed.
    packed: Option<Vec<u8>>,
}

impl ModelBytes {
    /// The file as it lies on disk.
    pub(super) fn stored(&self) -> &[u8] {
        self.packed.as_deref().unwrap_or(&self.bytes)
    }
}

impl ModelBytes {
    /// These bytes of a file that was another one on disk.
    pub(super) fn changed(self, bytes: Vec<u8>) -> Self {
        let stored = self.packed.unwrap_or(self.bytes);
        Self { bytes, packed: Some(stored) }
    }
}

impl Deref for ModelBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Reads a whole model file, packed or not.
pub(super) fn read_model(path: &Path) -> Result<ModelBytes, Failure> {
    let failure = |e| format!("{}: cannot be read: {e}", path.display());
    let length = std::fs::metadata(path).map_err(failure)?.len();
    let name = || path.display().to_string();
    memory::check(length, "give a smaller model", name)?;
    let bytes = std::fs::read(path).map_err(failure)?;
    // What is wrong with a file that is no model is said when it is opened.
    if !is_packed(&bytes).unwrap_or(false) {
        return Ok(ModelBytes { bytes, packed: None });
    }
    let refused = |e| format!("{}: {e}", path.display());
    memory::check(unpacked_len(&bytes).map_err(refused)?, "give a smaller model", name)?;
    let unpacked = pocketnerf_formats::unpacked(&bytes).map_err(refused)?.into_owned();
    Ok(ModelBytes { bytes: unpacked, packed: Some(bytes) })
}

/// Opens a model's bytes; the error names the file.
pub(super) fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<ModelFile<'a>, Failure> {
    refuse_baseline(path, bytes)?;
    open_verified(bytes).map_err(|e| format!("{}: {e}", path.display()).into())
}

/// The same, for rendering: `table` becomes the empty-space skip table.
pub(super) fn open_to_render<'a>(
    path: &Path,
    bytes: &'a [u8],
    table: &'a mut Vec<u8>,
) -> Result<ModelFile<'a>, Failure> {
    let mut file = open(path, bytes)?;
    let name = || format!("{}: the cells of this model", path.display());
    memory::check(file.model.table_len() as u64, "convert it with fewer cells", name)?;
    table.resize(file.model.table_len(), 0);
    file.model = file.model.with_table(table)?;
    Ok(file)
}
