//! Makes checksums right again after bytes were changed, so that tests and
//! fuzzers get past them. Independent of the crate that it tests.

/// Bytes of the header, and of an entry of the section table.
const HEADER: usize = 32;
const ENTRY: usize = 48;

/// Recomputes the checksum of every section inside the file, then the header's.
/// Leaves alone what is too damaged to have one.
pub fn repair(file: &mut [u8]) {
    let Some(count) = number(file, 12, 4) else { return };
    let end = HEADER.saturating_add((count as usize).saturating_mul(ENTRY));
    if end > file.len() {
        return;
    }
    for entry in (HEADER..end).step_by(ENTRY) {
        let (offset, length) = (number(file, entry + 16, 8), number(file, entry + 24, 8));
        let (Some(offset), Some(length)) = (offset, length) else { return };
        let Some(stop) = offset.checked_add(length) else { continue };
        if let Some(payload) = file.get(offset as usize..stop as usize) {
            let crc = crc32(payload);
            file[entry + 40..entry + 44].copy_from_slice(&crc.to_le_bytes());
        }
    }
    file[24..28].fill(0);
    let crc = crc32(&file[..end]);
    file[24..28].copy_from_slice(&crc.to_le_bytes());
}

/// The little-endian number of `size` bytes at `at`.
#[must_use]
pub fn number(bytes: &[u8], at: usize, size: usize) -> Option<u64> {
    let bytes = bytes.get(at..at + size)?;
    Some(bytes.iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte)))
}

/// CRC-32 (IEEE 802.3), bit by bit.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = !0;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
        }
    }
    !crc
}
