//! The folder of images nearest to the requested size.

use std::path::Path;

use crate::dataset::DatasetError;

/// Where the images of a capture are.
pub(in crate::dataset) struct Images {
    /// Relative to the capture's folder.
    pub(in crate::dataset) folder: String,
    /// How many times smaller they must be made.
    pub(in crate::dataset) factor: u32,
    /// What the user should know.
    pub(in crate::dataset) notes: Vec<String>,
}

/// `images_K` holds images K times smaller than `images`. Chosen is the folder of
/// `factor`; else the smallest whose images can be made smaller to that; else the
/// largest there is, whose images count as the full ones.
pub(in crate::dataset) fn choose(capture: &Path, factor: u32) -> Result<Images, DatasetError> {
    let mut folders: Vec<(u32, String)> = Vec::new();
    let unlistable =
        |folder: &Path, source| DatasetError::Unlistable { folder: folder.to_owned(), source };
    for entry in std::fs::read_dir(capture).map_err(|error| unlistable(capture, error))? {
        let entry = entry.map_err(|error| unlistable(capture, error))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let smaller = match name.strip_prefix("images") {
            Some("") => Some(1),
            Some(rest) => rest.strip_prefix('_').and_then(|k| k.parse().ok()).filter(|k| *k > 0),
            None => None,
        };
        if let Some(smaller) = smaller.filter(|_| entry.path().is_dir()) {
            folders.push((smaller, name));
        }
    }
    folders.sort();
    let of_factor = |(smaller, _): &&(u32, String)| factor.is_multiple_of(*smaller);
    let chosen = folders.iter().rev().filter(|_| factor > 0).find(of_factor);
    let Some((smaller, folder)) = chosen.or(folders.first()) else {
        return Err(DatasetError::NoImageFolder(capture.to_owned()));
    };
    let mut notes = Vec::new();
    let (mut rest, is_exact) = (factor, chosen.is_some());
    if is_exact {
        rest = factor / smaller;
    } else if factor == 1 {
        notes.push(format!("no folder images: those in {folder} count as the full images"));
    } else {
        notes.push(format!(
            "no images that {factor} times smaller ones can be made of: those in {folder} are made {factor} times smaller"
        ));
    }
    Ok(Images { folder: folder.clone(), factor: rest, notes })
}
