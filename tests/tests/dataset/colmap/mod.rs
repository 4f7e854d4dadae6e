//! COLMAP models.

mod files;
mod fixture;
mod lenses;
mod refusals;
mod world;

use pocketnerf_train::dataset::{Dataset, LoadOptions, Split, load_with};

use crate::fixture::Folder;

/// All images, this much smaller.
fn all(folder: &Folder, factor: u32) -> Dataset {
    let options = LoadOptions { downscale_factor: factor, hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap()
}
