//! Hash grids that other programs trained, against what those programs show
//! (`tests/fixtures/ngp.py`).

mod big;
mod damaged;
mod exact;
mod whole;

use std::path::{Path, PathBuf};

use pocketnerf_formats::import::ngp::Ngp;
use pocketnerf_formats::import::{Checkpoint, FieldError, inflate};

/// The fixture of this name.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/ngp").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap()
}

/// The field of a fixture's bytes.
fn ngp(bytes: &[u8]) -> Result<Ngp, FieldError> {
    let unpacked = inflate(bytes).unwrap();
    let checkpoint = Checkpoint::read(&unpacked).unwrap();
    assert!(Ngp::recognises(&checkpoint));
    Ngp::read(&checkpoint)
}
