//! Checkpoints that are not what they seem: refused in one line, never a panic.

use std::time::{Duration, Instant};

use pocketnerf_core::{Ray, SimdLevel};
use pocketnerf_formats::import::{Checkpoint, FieldError};
use pocketnerf_tests::damage::{mutate, without_archive_checksums};
use pocketnerf_train::convert::ConvertError;
use pocketnerf_train::random::Random;

use super::{bytes, volume};

/// Mutations of every file.
const MUTATIONS: u64 = 10_000;

/// Reads a file as far as it can be, and looks along a few rays.
fn use_everything(bytes: &[u8]) -> bool {
    let Ok(checkpoint) = Checkpoint::read(bytes) else { return false };
    let volume = match volume(&checkpoint, SimdLevel::detect()) {
        Ok(volume) => volume,
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            return false;
        }
    };
    let along = |x: f32| Ray { origin: [x, 0.1, -3.0], direction: [0.0, 0.0, 1.0] };
    assert_eq!(volume.painter().colors(&[along(0.0), along(0.3)]).len(), 2);
    true
}

#[test]
fn ten_thousand_mutations() {
    let files = ["features.th", "harmonics.th", "lines.th", "four.npz"];
    let each = |(file, name): (usize, &&str)| {
        let whole = without_archive_checksums(bytes(name));
        let mut fields = 0;
        for i in 0..MUTATIONS {
            let mut random = Random::new(21, [file as u64, i, 0]);
            let mut bytes = whole.clone();
            (0..=random.below(3)).for_each(|_| mutate(&mut random, &mut bytes));
            let begun = Instant::now();
            fields += u32::from(use_everything(&bytes));
            assert!(begun.elapsed() < Duration::from_secs(5), "{name}, mutation {i}");
        }
        println!("{name}: {fields} of {MUTATIONS} damaged versions are volumes");
        assert!(fields > 0, "{name}");
    };
    std::thread::scope(|scope| {
        for file in files.iter().enumerate() {
            scope.spawn(move || each(file));
        }
    });
}

/// The bytes with one part, which is there once, replaced by another.
fn replaced(bytes: &[u8], part: &[u8], by: &[u8]) -> Vec<u8> {
    let places: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(part)).collect();
    assert_eq!(places.len(), 1, "{}", String::from_utf8_lossy(part));
    [&bytes[..places[0]], by, &bytes[places[0] + part.len()..]].concat()
}

#[test]
fn each_defect_is_named() {
    let whole = without_archive_checksums(bytes("features.th"));
    for (part, by, name) in [
        (&b"MLP_Fea"[..], &b"MLP_PEx"[..], "kwargs.shadingMode"),
        (b"softplus", b"softmaxx", "kwargs.fea2denseAct"),
        (b"density_shift", b"density_shaft", "kwargs.density_shift"),
        (b"density_line.1", b"density_lime.1", "density_line.1"),
        (b"basis_mat.weight", b"basis_mat.height", "basis_mat.weight"),
        (b"renderModule.mlp.2.bias", b"renderModule.mlp.2.bird", "renderModule.mlp.2.bias"),
    ] {
        let bytes = replaced(&whole, part, by);
        let error = volume(&Checkpoint::read(&bytes).unwrap(), SimdLevel::detect()).unwrap_err();
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
    // A grid whose spheres around it are not shown.
    let whole = without_archive_checksums(bytes("four.npz"));
    let at = (0..whole.len()).filter(|at| whole[*at..].starts_with(b"center.npy"));
    let mut bytes = whole.clone();
    for at in at.collect::<Vec<_>>() {
        bytes[at..at + 10].copy_from_slice(b"radius.npy");
    }
    // Two arrays of one name.
    assert!(Checkpoint::read(&bytes).is_err());
    let error = |name: &[u8], value: &[u8]| -> ConvertError {
        let at = (0..whole.len()).find(|at| whole[*at..].starts_with(name)).unwrap();
        let data = (at..whole.len()).find(|at| whole[*at..].starts_with(b"\n")).unwrap() + 1;
        let mut bytes = whole.clone();
        bytes[data..data + value.len()].copy_from_slice(value);
        volume(&Checkpoint::read(&bytes).unwrap(), SimdLevel::detect()).unwrap_err()
    };
    assert!(error(b"radius.npy", &0.0f32.to_le_bytes()).to_string().contains("radius"));
    assert!(error(b"links.npy", &99_999i32.to_le_bytes()).to_string().contains("links: 99999"));
    let infinite = error(b"density_data.npy", &f32::INFINITY.to_le_bytes());
    let expected = FieldError::NotFinite("density_data".to_owned());
    assert!(matches!(infinite, ConvertError::Field(found) if found == expected));
}
