//! Where the models of a capture are.

use std::path::Path;

use super::model::{count_images, is_model};
use crate::dataset::DatasetError;

/// Folders that hold models, or a folder for each: the first that does counts.
const PLACES: [&str; 3] = ["sparse", "colmap/sparse", ""];

/// The models of a capture, of the first place that has any: folders relative to it.
pub(super) fn models(capture: &Path) -> Vec<String> {
    let of = |place: &&str| {
        let inside = if place.is_empty() { Vec::new() } else { folders(&capture.join(place)) };
        let inside = inside.into_iter().map(|name| format!("{place}/{name}"));
        let models = inside.chain([(*place).to_owned()]);
        let mut models: Vec<String> = models.filter(|path| is_model(&capture.join(path))).collect();
        // The model beside others' folders is one that was left behind.
        if models.len() > 1 {
            models.retain(|path| path != place);
        }
        models
    };
    PLACES.iter().map(of).find(|models| !models.is_empty()).unwrap_or_default()
}

/// The model with the most images, and what to say where there are others.
pub(super) fn largest(
    capture: &Path,
    models: Vec<String>,
) -> Result<(String, Option<String>), DatasetError> {
    if let [one] = &models[..] {
        return Ok((one.clone(), None));
    }
    let count = |path: String| count_images(&capture.join(&path)).map(|images| (path, images));
    let counts = models.into_iter().map(count).collect::<Result<Vec<_>, _>>()?;
    let missing = || DatasetError::Missing(capture.to_owned());
    // The first of equals.
    let best = counts.iter().rev().max_by_key(|(_, images)| *images).ok_or_else(missing)?;
    let others: Vec<String> = counts
        .iter()
        .filter(|(path, _)| *path != best.0)
        .map(|(path, images)| format!("{path} {images}"))
        .collect();
    let note = format!(
        "{} models, of which {} has the most images, {}, and is taken ({})",
        counts.len(),
        best.0,
        best.1,
        others.join(", ")
    );
    Ok((best.0.clone(), Some(note)))
}

/// The names of the folders in one, numbers by their value.
fn folders(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.path().is_dir());
    let mut names: Vec<String> =
        folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort_by(|a, b| a.len().cmp(&b.len()).then_with(|| a.cmp(b)));
    names
}
