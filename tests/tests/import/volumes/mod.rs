//! Volumes that other programs trained, against what those programs show
//! (`tests/fixtures/volumes.py`).

mod damaged;
mod exact;

use std::path::Path;

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::import::Checkpoint;
use pocketnerf_formats::import::volume::{Svox2, TensoRf};
use pocketnerf_train::convert::{ConvertError, VolumeConversion};

fn bytes(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/volumes");
    std::fs::read(folder.join(name)).unwrap()
}

/// What a checkpoint holds, before black.
fn volume(checkpoint: &Checkpoint<'_>, simd: SimdLevel) -> Result<VolumeConversion, ConvertError> {
    let black = Some([0.0; 3]);
    match Svox2::recognises(checkpoint) {
        true => VolumeConversion::svox2(Svox2::read(checkpoint)?, None, black),
        false => VolumeConversion::tensorf(TensoRf::read(checkpoint)?, black, simd),
    }
}
