//! Checkpoints that are not what they seem: refused in one line, never a panic.

use std::time::{Duration, Instant};

use pocketnerf_formats::import::ngp::Ngp;
use pocketnerf_formats::import::{Checkpoint, FieldError, inflate};
use pocketnerf_tests::damage::{many_mutations, mutate, replaced, without_archive_checksums};
use pocketnerf_train::random::Random;

use super::{bytes, ngp};

/// Mutations of every file.
const MUTATIONS: u64 = 10_000;

/// The error of the snapshot with one part replaced.
#[track_caller]
fn refused(part: &[u8], by: &[u8]) -> FieldError {
    let error = ngp(&replaced(&bytes("fused.msgpack"), part, by)).unwrap_err();
    assert!(!error.to_string().contains('\n'));
    error
}

#[test]
fn each_defect_is_named() {
    for (part, by, name) in [
        (&b"\xa8HashGrid"[..], &b"\xa8TileGrid"[..], "encoding.otype"),
        (b"\xa4mode\xa4nerf", b"\xa4mode\xa3sdf", "snapshot.mode"),
        (b"\xb2SphericalHarmonics", b"\xa7OneBlob", "dir_encoding.nested.0.otype"),
        (b"\xa6degree\x04", b"\xa6degree\x03", "dir_encoding.nested.0.degree"),
        (b"\xb6n_extra_learnable_dims\x00", b"\xb6n_extra_learnable_dims\x08", "n_extra_learnable"),
        (b"\xa6is_hdr\xc2", b"\xa6is_hdr\xc3", "is_hdr"),
        (b"\xa8n_levels\x04", b"\xa8n_levels\x05", "snapshot.params_binary"),
        (b"\xa8n_levels\x04", b"\xa8n_levels\x7f", "encoding.n_levels"),
        (b"\xa6__half", b"\xa4int8", "snapshot.params_type"),
        (b"\xb1density_grid_size\x20", b"\xb1density_grid_size\x10", "density_grid_binary"),
    ] {
        match refused(part, by) {
            FieldError::Setting { name: found, .. } => assert!(found.contains(name), "{found}"),
            other => panic!("{name}: {other}"),
        }
    }
    let missing = refused(b"\xa8n_params", b"\xa8m_params");
    assert_eq!(missing, FieldError::Missing("snapshot.n_params".to_owned()));
    // A parameter that is no number.
    let mut bytes = bytes("fused.msgpack");
    let key = b"params_binary\xc5";
    let at = (0..bytes.len()).find(|at| bytes[*at..].starts_with(key)).unwrap() + key.len() + 2;
    bytes[at..at + 2].copy_from_slice(&[0x00, 0x7e]);
    assert_eq!(
        ngp(&bytes).unwrap_err(),
        FieldError::NotFinite("snapshot.params_binary".to_owned())
    );
}

/// Reads a file as far as it can be, and makes the field of it.
fn use_everything(packed: &[u8]) -> bool {
    let Ok(unpacked) = inflate(packed) else { return false };
    let Ok(checkpoint) = Checkpoint::read(&unpacked) else { return false };
    match Ngp::read(&checkpoint) {
        Ok(ngp) => {
            // Whatever it says: a field that core has checked.
            let _ = ngp.field();
            if let Some(cells) = &ngp.context().cells {
                let _ = cells.on_grid(64).count();
            }
            true
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            false
        }
    }
}

#[test]
fn ten_thousand_mutations() {
    let files = [
        "fused.msgpack",
        "old.msgpack",
        "torch/torch_ngp.pth",
        "torch/ngp_pl.ckpt",
        "torch/nerfstudio_tcnn/nerfstudio_models/step-000000009.ckpt",
        "torch/nerfstudio_torch/nerfstudio_models/step-000000009.ckpt",
    ];
    let files = files.map(|name| (name, without_archive_checksums(bytes(name))));
    many_mutations(&files, MUTATIONS, 11, use_everything);
}

/// Unpacking takes a while, so there are fewer of these.
#[test]
fn compressed_ones() {
    for name in ["cutlass.ingp", "cutlass_gzip.ingp"] {
        let whole = bytes(name);
        for i in 0..200 {
            let mut random = Random::new(12, [name.len() as u64, i, 0]);
            let mut bytes = whole.clone();
            mutate(&mut random, &mut bytes);
            let begun = Instant::now();
            use_everything(&bytes);
            assert!(begun.elapsed() < Duration::from_secs(5), "{name}, mutation {i}");
        }
    }
}

#[test]
fn every_truncation_is_refused() {
    let whole = bytes("old.msgpack");
    for end in 0..whole.len() {
        assert!(Checkpoint::read(&whole[..end]).is_err(), "{end} of {}", whole.len());
    }
}
