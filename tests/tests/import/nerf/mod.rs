//! Models that other programs trained, against what those programs show.

mod damaged;
mod exact;
mod real;
mod whole;

use std::path::{Path, PathBuf};

use pocketnerf_formats::import::Checkpoint;
use pocketnerf_formats::import::FieldError;
use pocketnerf_formats::import::nerf::Nerf;

/// The fixture of this name, see `tests/fixtures/nerf_networks.py`.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nerf_networks").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap()
}

/// The networks of a fixture's bytes.
fn nerf(bytes: &[u8]) -> Result<Nerf, FieldError> {
    Nerf::read(&Checkpoint::read(bytes).unwrap())
}

/// The networks of the fixture in two files.
fn pair() -> Nerf {
    let [coarse, fine] = ["model_000007.npy", "model_fine_000007.npy"].map(bytes);
    let [coarse, fine] = [&coarse, &fine].map(|bytes| Checkpoint::read(bytes).unwrap());
    Nerf::read_both(&coarse, &fine).unwrap()
}
