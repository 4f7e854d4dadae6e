//! Damages files in the ways that files are damaged.

use pocketnerf_train::random::Random;

/// An archive without the checksums that would hide all other damage; other files as they
/// are.
#[must_use]
pub fn without_archive_checksums(mut bytes: Vec<u8>) -> Vec<u8> {
    for at in 0..bytes.len().saturating_sub(20) {
        if bytes[at..].starts_with(b"PK\x01\x02") {
            bytes[at + 16..at + 20].fill(0);
        }
    }
    bytes
}

/// Changes a file in one of the ways that files are damaged.
pub fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    match random.below(8) {
        0..=2 => bytes[at] ^= 1 << random.below(8),
        3 | 4 => bytes[at] = random.next_u64() as u8,
        5 => bytes.truncate(at),
        spliced => {
            let from = random.below(bytes.len());
            let n = 1 + random.below(64);
            let piece: Vec<u8> = bytes[from..].iter().take(n).copied().collect();
            let stop = if spliced == 6 { at } else { (at + piece.len()).min(bytes.len()) };
            bytes.splice(at..stop, piece);
        }
    }
}
