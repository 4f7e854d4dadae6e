//! What `torch.save` writes.

pub(super) mod legacy;
pub(super) mod zip;

use super::ImportError;
use super::error::shown;
use super::pickle::TorchStorage;

/// The part of a storage's bytes that a tensor may lie in.
fn part<'a>(storage: &TorchStorage<'a>, bytes: &'a [u8]) -> Result<&'a [u8], ImportError> {
    let size = storage.element_size();
    let in_bytes = |n: usize| n.saturating_mul(size);
    if bytes.len() != in_bytes(storage.len) {
        return Err(ImportError::Storage {
            key: shown(storage.key),
            expected: in_bytes(storage.len) as u64,
            found: bytes.len() as u64,
        });
    }
    let Some((offset, len)) = storage.view else { return Ok(bytes) };
    let end = offset.saturating_add(len);
    bytes.get(in_bytes(offset)..in_bytes(end)).ok_or_else(|| ImportError::Storage {
        key: shown(storage.key),
        expected: in_bytes(end) as u64,
        found: bytes.len() as u64,
    })
}
