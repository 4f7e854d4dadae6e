//! Damaged files: whatever the bytes, reading ends soon, without a panic and without
//! taking much memory, and a tensor that is found can be decoded.

use std::time::{Duration, Instant};

use pocketnerf_formats::import::{Checkpoint, ImportError};
use pocketnerf_tests::damage::{mutate, without_archive_checksums};
use pocketnerf_train::random::Random;

use super::counting::most_held;
use super::fixture;

const FIXTURES: [&str; 18] = [
    "../ngp/old.msgpack",
    "numpy/arrays.npz",
    "numpy/arrays_compressed.npz",
    "numpy/big_endian.npy",
    "big_endian.pt",
    "compressed.pt",
    "eval.pt",
    "numpy/fortran.npy",
    "legacy.pt",
    "legacy_protocol_4.pt",
    "lightning.ckpt",
    "little_endian.pt",
    "tensor.pt",
    "tiny.safetensors",
    "numpy/weights.npy",
    "numpy/weights_protocol_2.npy",
    "numpy/weights_protocol_5.npy",
    "zip.pt",
];

/// Reads a file and every tensor in it.
fn use_everything(bytes: &[u8]) -> Result<usize, ImportError> {
    let started = Instant::now();
    let mut read = Ok(0);
    let held = most_held(|| {
        read = Checkpoint::read(bytes).map(|checkpoint| {
            for name in checkpoint.names() {
                let tensor = checkpoint.tensor(name).unwrap();
                // Decoding has a limit of its own, of which these would take long to fill.
                if tensor.len() < 1 << 20 {
                    assert_eq!(tensor.to_f32().unwrap().len(), tensor.len());
                }
            }
            checkpoint.names().count()
        });
        if let Err(error) = &read {
            let message = error.to_string();
            assert!(message.len() < 2000 && !message.contains('\n'), "{message}");
        }
    });
    assert!(held <= (64 << 20) + 4 * bytes.len(), "{held} bytes held");
    assert!(started.elapsed() < Duration::from_secs(5));
    read
}

#[test]
fn damage_is_survived() {
    for (index, name) in FIXTURES.iter().enumerate() {
        let sound = without_archive_checksums(fixture(name));
        let mut readable = 0;
        for version in 0..10_000 {
            let mut random = Random::new(7, [index as u64, version, 0]);
            let mut bytes = sound.clone();
            for _ in 0..=random.below(3) {
                mutate(&mut random, &mut bytes);
            }
            readable += u32::from(use_everything(&bytes).is_ok());
        }
        println!("{name}: {readable} of 10000 damaged versions can be read");
    }
}

/// Legacy files, arrays and safetensors say how long they are; an archive ends with
/// its table.
#[test]
fn every_truncation_is_refused() {
    for name in FIXTURES {
        let bytes = fixture(name);
        for end in 0..bytes.len() {
            let read = use_everything(&bytes[..end]);
            assert!(read.is_err(), "{name}: {end} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn every_byte_can_be_any_other() {
    for name in ["legacy.pt", "numpy/weights.npy", "tiny.safetensors"] {
        let sound = fixture(name);
        for at in 0..sound.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff, b'.', b'(', b'0', sound[at].wrapping_add(1)] {
                let mut bytes = sound.clone();
                bytes[at] = value;
                let _ = use_everything(&bytes);
            }
        }
    }
}

#[test]
fn bytes_after_the_end_are_refused() {
    for name in [
        "legacy.pt",
        "numpy/weights.npy",
        "numpy/fortran.npy",
        "tiny.safetensors",
        "../ngp/old.msgpack",
    ] {
        let bytes = [fixture(name), vec![0; 3]].concat();
        assert_eq!(use_everything(&bytes), Err(ImportError::Trailing { bytes: 3 }), "{name}");
    }
}
