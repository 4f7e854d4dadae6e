//! Packed files: ordinary ones come back, render to the same bytes, and no damage does harm.

mod by_hand;
mod planes;
mod symbols;

use std::borrow::Cow;

use crate::rounded;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Probe, RenderOptions, SimdLevel, Tuning};
use pocketnerf_formats::{
    Container, FormatError, ModelFile, Precision, SectionId, WriteError, is_packed, kind, open,
    open_verified, pack, unpack_into, unpacked, unpacked_len, write,
};
use pocketnerf_tests::checksums::repair;
use pocketnerf_tests::damage::mutate;
use pocketnerf_tests::tiny::{self, Tiny};
use pocketnerf_train::random::Random;

pub(crate) fn still_life() -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../embed-demo/still-life.pnerf")).unwrap()
}

fn tiny_files() -> [Vec<u8>; 10] {
    let (tiny, trained) = (Tiny::new(), Tiny::trained());
    let written = |model, precision| write(model, &tiny::about(), precision).unwrap();
    [
        written(&trained.hash_grid(), Precision::I8),
        written(&tiny.hash_grid(), Precision::I8),
        written(&tiny.hash_grid(), Precision::F16),
        written(&tiny.per_sample(), Precision::F32),
        written(&tiny.nerf(), Precision::F16),
        written(&trained.plenoxels(), Precision::I8),
        written(&trained.planes(), Precision::I8),
        planes::smooth(),
        written(&trained.derf(), Precision::F16),
        rounded::networks(&written(&trained.hash_grid(), Precision::I8), 4096.0),
    ]
}

/// A picture of the model, every pixel rendered.
fn picture(file: &ModelFile<'_>) -> Vec<f32> {
    let (model, camera) = (&file.model, file.camera(96, 72));
    let options = RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST);
    let mut scratch = vec![0.0; options.scratch_len()];
    let mut all = Vec::new();
    for tile in Tiles::new(camera.width, camera.height) {
        let mut rgba = vec![0.0; 4 * tile.pixels()];
        pocketnerf_core::render_tile(model, &camera, tile, &options, &mut scratch, &mut rgba, None)
            .unwrap();
        all.extend(rgba);
    }
    all
}

/// Gradients of the density at the corners of occupied cells: their differences reach beyond.
fn slopes(file: &ModelFile<'_>) -> Vec<[f32; 3]> {
    let probe = Probe::new(&file.model, SimdLevel::detect(), Tuning::FAST).unwrap();
    let mut scratch = vec![0.0; probe.scratch_len()];
    let (cells, map) = (file.model.occupancy.unwrap(), file.model.space.unit_map());
    let n = cells.resolution();
    let occupied = (0..n * n * n).map(|cell| [cell % n, cell / n % n, cell / (n * n)]);
    let occupied = occupied.filter(|[x, y, z]| cells.cell(*x, *y, *z)).enumerate();
    let points = occupied.map(|(i, cell)| {
        [0, 1, 2].map(|a| {
            let inside = if i >> a & 1 == 0 { 1e-3 } else { 1.0 - 1e-3 };
            map.min[a] + (cell[a] as f32 + inside) / n as f32 / map.scale
        })
    });
    let points: Vec<[f32; 3]> = points.collect();
    let mut slopes = vec![[0.0; 3]; points.len()];
    probe.density_gradient(&points, &mut scratch, &mut slopes).unwrap();
    assert!(slopes.iter().filter(|slope| **slope != [0.0; 3]).count() > 10_000);
    slopes
}

/// The file with the largest values there are wherever packing would put 0.
fn poisoned(bytes: &[u8]) -> Vec<u8> {
    let cleared = unpacked(&pack(bytes).unwrap()).unwrap().into_owned();
    let head = 32 + 48 * u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut poisoned = bytes.to_vec();
    for (i, value) in poisoned.iter_mut().enumerate().skip(head) {
        if cleared[i] != *value {
            *value = 127;
        }
    }
    repair(&mut poisoned);
    poisoned
}

#[test]
fn a_model_of_a_scene_packs_and_looks_the_same() {
    let bytes = still_life();
    let packed = pack(&bytes).unwrap();
    println!("{} of {} bytes", packed.len(), bytes.len());
    // Its tables have 16 bits, of which eight are hardly worth a coder.
    assert!(10 * packed.len() < 7 * bytes.len(), "{} of {}", packed.len(), bytes.len());
    assert!(is_packed(&packed).unwrap() && !is_packed(&bytes).unwrap());
    let back = unpacked(&packed).unwrap();
    assert_eq!((back.len(), unpacked_len(&packed)), (bytes.len(), Ok(bytes.len() as u64)));
    let [ours, theirs] = [&bytes, &*back].map(|bytes| open_verified(bytes).unwrap());
    assert!(picture(&ours) == picture(&theirs));
    // All but entries that nothing reads is the same to the byte.
    for (a, b) in ours.sections().zip(theirs.sections()) {
        assert_eq!((a.id, a.bytes.len()), (b.id, b.bytes.len()));
        let changed = a.bytes.iter().zip(b.bytes).filter(|(a, b)| a != b);
        let zero = |(_, b): (&u8, &u8)| *b == 0;
        assert!(a.bytes == b.bytes || (a.id.kind == kind::GRID && changed.clone().all(zero)));
    }
    // What has been packed once packs to the same bytes.
    assert_eq!(pack(&back).unwrap(), packed);
    // An ordinary file stands for itself.
    assert!(matches!(unpacked(&bytes).unwrap(), Cow::Borrowed(same) if same == bytes));
}

/// Whatever lies where nothing reads, pictures and gradients are the same.
#[test]
fn nothing_reads_what_becomes_0() {
    let file = still_life();
    let plain = open(&file).unwrap();
    let bytes = write(&plain.model, &plain.about, Precision::I8).unwrap();
    let bytes = poisoned(&bytes);
    let packed = pack(&bytes).unwrap();
    let back = unpacked(&packed).unwrap();
    let changed = bytes.iter().zip(&*back).filter(|(a, b)| **a == 127 && **b == 0).count();
    assert!(changed > 400, "{changed}");
    let [ours, theirs] = [&bytes, &*back].map(|bytes| open_verified(bytes).unwrap());
    assert!(picture(&ours) == picture(&theirs));
    assert!(slopes(&ours) == slopes(&theirs));
}

#[test]
fn small_files_of_every_kind_come_back() {
    for bytes in tiny_files() {
        let packed = pack(&bytes).unwrap();
        let back = unpacked(&packed).unwrap();
        let [ours, theirs] = [&bytes, &*back].map(|bytes| open_verified(bytes).unwrap());
        assert!(picture(&ours) == picture(&theirs));
        assert!(packed.len() <= bytes.len());
    }
}

#[test]
fn refusals() {
    let packed = pack(&still_life()).unwrap();
    let needed = unpacked_len(&packed).unwrap();
    let mut short = vec![7; needed as usize - 1];
    let room = FormatError::Room { needed, given: needed - 1 };
    assert_eq!(unpack_into(&packed, &mut short), Err(room));
    assert!(short.iter().all(|byte| *byte == 7));
    // More room than needed is left alone.
    let mut long = vec![7; needed as usize + 9];
    assert_eq!(unpack_into(&packed, &mut long), Ok(needed as usize));
    assert_eq!(long[needed as usize..], [7; 9]);
    // Who opens a packed file is told what to do.
    let error = open_verified(&packed).unwrap_err();
    assert!(matches!(error, FormatError::UnknownEncoding { .. }));
    assert!(error.to_string().ends_with("; a packed file has to be unpacked first"), "{error}");
    assert!(matches!(pack(&packed), Err(WriteError::Unreadable(_))));
    // A damaged payload is found by its checksum, before it is decoded.
    let mut damaged = packed.clone();
    *damaged.last_mut().unwrap() ^= 1;
    let section = SectionId::first(kind::OCC_FINE);
    let error = unpacked(&damaged).unwrap_err();
    assert!(matches!(error, FormatError::Checksum { section: s, .. } if s == section), "{error}");
}

/// A section that a newer program wrote, in an encoding of its own, stays as it is where the file
/// can do without it.
#[test]
fn sections_in_unknown_encodings_stay() {
    let plain = still_life();
    let id = SectionId::first(kind::PROVENANCE);
    let place = |bytes: &[u8]| {
        let table = bytes[32..].chunks(48);
        table.take_while(|e| e[0] != kind::PROVENANCE as u8).count() * 48 + 32
    };
    let mut newer = plain.clone();
    let at = place(&plain);
    (newer[at + 10], newer[at + 32]) = (77, 1);
    repair(&mut newer);
    let section = |bytes: &[u8]| {
        let section = Container::open(bytes).unwrap().find(id).unwrap();
        (section.encoding, section.decoded_length, section.bytes.to_vec())
    };
    assert_eq!(section(&newer).0, 77);
    assert!(open_verified(&newer).is_ok() && !is_packed(&newer).unwrap());
    let packed = pack(&newer).unwrap();
    assert!(is_packed(&packed).unwrap() && section(&packed) == section(&newer));
    let back = unpacked(&packed).unwrap();
    assert!(section(&back) == section(&newer) && open_verified(&back).is_ok());
}

/// Whatever the bytes, checksums repaired or not, unpacking ends, and writes what it says.
#[test]
fn damage_does_no_harm() {
    let whole: Vec<Vec<u8>> = tiny_files().iter().map(|bytes| pack(bytes).unwrap()).collect();
    let (mut refused, mut taken) = (0, 0);
    for seed in 0..20_000 {
        let mut random = Random::new(seed, [7, 0, 0]);
        let mut bytes = whole[random.below(whole.len())].clone();
        mutate(&mut random, &mut bytes);
        if random.below(8) > 0 {
            repair(&mut bytes);
        }
        match unpacked_len(&bytes) {
            Ok(needed) if needed < 1 << 24 => {
                let mut out = vec![7; needed as usize + 64];
                match unpack_into(&bytes, &mut out) {
                    Ok(written) => {
                        assert_eq!(written as u64, needed);
                        let again = Container::open(&out[..written]);
                        again.unwrap().verify().unwrap();
                        taken += 1;
                    }
                    Err(_) => refused += 1,
                }
                assert!(out[needed as usize..].iter().all(|byte| *byte == 7));
            }
            _ => refused += 1,
        }
    }
    assert!(refused > 1000 && taken > 100, "{refused} {taken}");
}
