//! Damages files in the ways that files are damaged.

use std::time::{Duration, Instant};

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

/// The bytes with one part, which is there once, replaced by another.
///
/// # Panics
/// Where it is not there, or more than once.
#[must_use]
pub fn replaced(bytes: &[u8], part: &[u8], by: &[u8]) -> Vec<u8> {
    let places: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(part)).collect();
    assert_eq!(places.len(), 1, "{}", String::from_utf8_lossy(part));
    [&bytes[..places[0]], by, &bytes[places[0] + part.len()..]].concat()
}

/// Damages each of these files in so many ways, one thread a file, and counts the versions that
/// `use_everything` still finds a use for.
///
/// # Panics
/// If it panics, or takes five seconds, or never finds one.
pub fn many_mutations(
    files: &[(&str, Vec<u8>)],
    count: u64,
    seed: u64,
    use_everything: impl Fn(&[u8]) -> bool + Sync,
) {
    let each = &|(file, (name, whole)): (usize, &(&str, Vec<u8>))| {
        let mut useful = 0;
        for i in 0..count {
            let mut random = Random::new(seed, [file as u64, i, 0]);
            let mut bytes = whole.clone();
            (0..=random.below(3)).for_each(|_| mutate(&mut random, &mut bytes));
            let begun = Instant::now();
            useful += u32::from(use_everything(&bytes));
            assert!(begun.elapsed() < Duration::from_secs(5), "{name}, mutation {i}");
        }
        println!("{name}: {useful} of {count} damaged versions are of use");
        assert!(useful > 0, "{name}");
    };
    std::thread::scope(|scope| {
        for file in files.iter().enumerate() {
            scope.spawn(move || each(file));
        }
    });
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
