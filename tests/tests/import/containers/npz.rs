//! What `numpy.savez` and `numpy.savez_compressed` write.

use pocketnerf_formats::import::{Checkpoint, Container, ElementType, ImportError};

use super::{expect, fixture, tensor};

#[test]
fn arrays_by_name() {
    for file in ["numpy/arrays.npz", "numpy/arrays_compressed.npz"] {
        let bytes = fixture(file);
        let checkpoint = Checkpoint::read(&bytes).unwrap();
        assert_eq!(checkpoint.container(), Container::Npz, "{file}");
        let names = ["Conv_0/kernel", "Conv_0/bias", "fortran", "number", "repeated"];
        assert!(checkpoint.names().eq(names));
        expect(&checkpoint, "Conv_0/kernel", &[2, 3], &[0, 1, 2, 3, 4, 5]);
        expect(&checkpoint, "Conv_0/bias", &[3], &[0, 1, 2]);
        expect(&checkpoint, "fortran", &[2, 3], &[0, 1, 2, 3, 4, 5]);
        expect(&checkpoint, "number", &[], &[2]);
        expect(&checkpoint, "repeated", &[4096], &[0; 4096]);
        assert_eq!(tensor(&checkpoint, "number").element_type(), ElementType::F16);
    }
}

/// Where a text stands first.
fn find(bytes: &[u8], text: &[u8]) -> usize {
    bytes.windows(text.len()).position(|window| window == text).unwrap()
}

/// The file, with a text of as many bytes in place of another wherever that stands.
fn with(mut bytes: Vec<u8>, text: &[u8], other: &[u8]) -> Vec<u8> {
    for at in 0..bytes.len() - text.len() {
        if bytes[at..].starts_with(text) {
            bytes[at..at + text.len()].copy_from_slice(other);
        }
    }
    bytes
}

fn refused(bytes: &[u8]) -> String {
    Checkpoint::read(bytes).unwrap_err().to_string()
}

#[test]
fn entries_are_refused_by_name() {
    let unchecked = |file| pocketnerf_tests::damage::without_archive_checksums(fixture(file));
    let stored = || unchecked("numpy/arrays.npz");
    assert_eq!(
        refused(&with(stored(), b"<f2", b"|O8")),
        "the entry number.npy: values of type |O8 are not read"
    );
    assert_eq!(
        refused(&with(stored(), b"(4096,)", b"(4095,)")),
        "the entry repeated.npy: 4 bytes after the end of the checkpoint, where none were expected"
    );
    let none = with(stored(), b".npy", b".txt");
    assert_eq!(refused(&none), "data.pkl: not in the file");

    let mut damaged = fixture("numpy/arrays.npz");
    let at = find(&damaged, b"(4096,)") + 200;
    damaged[at] ^= 1;
    let error = Checkpoint::read(&damaged).unwrap_err();
    assert!(matches!(error, ImportError::Checksum { .. }), "{error}");
}

#[test]
fn what_does_not_unpack_is_refused() {
    let sound = fixture("numpy/arrays_compressed.npz");
    let record = find(&sound, b"PK\x01\x02");
    let damaged = |at: usize, value: &[u8]| {
        let mut bytes = sound.clone();
        bytes[record + at..][..value.len()].copy_from_slice(value);
        refused(&bytes)
    };
    // The size of the contents: less than there are, more, and more than is allowed.
    let entry = "the zip archive cannot be read: the entry Conv_0/kernel.npy:";
    assert_eq!(damaged(24, &[100, 0, 0, 0]), format!("{entry} it does not unpack to 100 bytes"));
    assert_eq!(damaged(24, &[0, 1, 0, 0]), format!("{entry} it does not unpack to 256 bytes"));
    assert!(damaged(24, &[0xfe; 4]).starts_with("bytes of memory for the file: more than"));
    // Encrypted, and by another method.
    let other = format!("{entry} encrypted, or compressed in a way that numpy has none of");
    assert_eq!(damaged(8, &[1]), other);
    assert_eq!(damaged(10, &[93]), other);
}
