//! Cameras of photogrammetry.

mod metashape;
mod reality_capture;

use pocketnerf_train::dataset::{Dataset, LoadOptions, Split, load_with};

use crate::fixture::Folder;

/// All frames, none held out.
fn all(folder: &Folder) -> Dataset {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap()
}

/// Whether vectors are the same to five digits: what cameras look at is found in single precision.
fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}
