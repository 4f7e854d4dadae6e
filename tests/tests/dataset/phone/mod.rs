//! What phone apps export.

mod polycam;
mod record3d;
mod scanner;

use pocketnerf_train::dataset::{Dataset, LoadOptions, Split, load_with};

use crate::fixture::Folder;

/// All frames, none held out.
fn all(folder: &Folder) -> Dataset {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap()
}
