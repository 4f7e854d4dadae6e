//! The photographs of a capture: where they are, their masks, and those that are not registered.

use std::collections::HashSet;
use std::path::Path;

use crate::dataset::capture::{Images, choose};
use crate::dataset::listing::{Frame, Mask};
use crate::dataset::{DatasetError, images};
use crate::json::escape;

/// The folder of photographs for a factor; the capture's own where it has none and `first` is
/// there.
pub(super) fn folder(capture: &Path, factor: u32, first: &str) -> Result<Images, DatasetError> {
    match choose(capture, factor) {
        Err(DatasetError::NoImageFolder(_)) if images::find(capture, first).is_some() => {
            Ok(Images { folder: String::new(), factor, notes: Vec::new() })
        }
        chosen => chosen,
    }
}

/// Where the image of a name is, relative to the capture: in smaller images the ending may
/// be another.
pub(super) fn path(capture: &Path, folder: &str, name: &str) -> String {
    let path = inside(folder, name);
    let other = || {
        let stem = stem(&path);
        (stem != path).then(|| images::find(capture, stem)).flatten()
    };
    if capture.join(&path).is_file() { path } else { other().unwrap_or(path) }
}

/// The mask of the image of a name: `masks/NAME.png`, perhaps without the image's own ending,
/// or the same in the folder of smaller masks. Black pixels are ignored.
pub(super) fn mask(capture: &Path, folder: &str, name: &str) -> Option<Mask> {
    let smaller = folder.strip_prefix("images").unwrap_or_default();
    let folders = [format!("masks{smaller}"), "masks".to_owned()];
    let names = [format!("{name}.png"), format!("{}.png", stem(name))];
    let mut paths = folders.iter().flat_map(|folder| names.iter().map(|name| inside(folder, name)));
    let path = paths.find(|path| capture.join(path).is_file())?;
    Some(Mask { path, black_counts: false, may_be_larger: true })
}

/// What to say of photographs that the model does not have.
pub(super) fn unregistered(capture: &Path, folder: &str, frames: &[Frame]) -> Option<String> {
    if folder.is_empty() {
        return None;
    }
    let mut all = Vec::new();
    collect(capture, folder, &mut all);
    all.sort();
    let known: HashSet<&str> = frames.iter().map(|frame| frame.path.as_str()).collect();
    let (total, mut unknown) =
        (all.len(), all.iter().filter(|path| !known.contains(path.as_str())));
    let first = unknown.next()?;
    Some(format!(
        "{} of the {total} images in {folder} are not registered (first: {}): they are not used",
        1 + unknown.count(),
        escape(first)
    ))
}

/// The images in a folder and in those inside it. Links to folders are not followed.
fn collect(capture: &Path, folder: &str, all: &mut Vec<String>) {
    let at = capture.join(folder);
    let names = images::names(&at, &images::EXTENSIONS).unwrap_or_default();
    all.extend(names.iter().map(|name| inside(folder, name)));
    for entry in std::fs::read_dir(&at).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            collect(capture, &inside(folder, &entry.file_name().to_string_lossy()), all);
        }
    }
}

fn inside(folder: &str, name: &str) -> String {
    if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") }
}

fn stem(path: &str) -> &str {
    match path.rsplit_once('.') {
        Some((stem, ending)) if !ending.contains('/') => stem,
        _ => path,
    }
}
