//! Tables of values, in whole words.

use alloc::vec::Vec;

use pocketnerf_core::{DType, TensorView};

/// Appends a table to `words`, which hold others of its type; returns the number of its first
/// value.
#[inline(never)]
pub(super) fn push(table: &TensorView<'_>, words: &mut Vec<u32>) -> usize {
    let per_word = size_of::<u32>() / table.dtype().size();
    let first = words.len() * per_word;
    for bytes in table.bytes().chunks(size_of::<u32>()) {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        words.push(u32::from_le_bytes(word));
    }
    first
}

/// The file of the shader that reads such tables.
pub(crate) const fn reader(dtype: DType) -> Option<&'static str> {
    match dtype {
        DType::F32 => Some(wgsl!("stored_f32")),
        DType::F16 => Some(wgsl!("stored_f16")),
        DType::I8 => Some(wgsl!("stored_i8")),
        _ => None,
    }
}
