//! Frames whose images are there.

use std::path::Path;

use crate::dataset::listing::Frame;
use crate::dataset::{DatasetError, images};
use crate::json;

/// The frames that have an image, and the images that others lack. `file` lists them;
/// `companions` adds what belongs to an image of that name.
pub(in crate::dataset) fn with_images(
    folder: &Path,
    file: &Path,
    frames: Vec<Frame>,
    notes: &mut Vec<String>,
    mut companions: impl FnMut(&str, &mut Frame),
) -> Result<(Vec<Frame>, Vec<String>), DatasetError> {
    let total = frames.len();
    let (mut found, mut missing) = (Vec::with_capacity(total), Vec::new());
    for mut frame in frames {
        match images::find(folder, &frame.path) {
            Some(name) => {
                companions(&name, &mut frame);
                frame.path = name;
                found.push(frame);
            }
            None => missing.push(frame.path),
        }
    }
    let Some(first) = missing.first() else { return Ok((found, missing)) };
    if 2 * missing.len() > total {
        let image = folder.join(first);
        let (file, missing) = (file.to_owned(), missing.len());
        return Err(DatasetError::MissingImage { image, file, missing, total });
    }
    notes.push(format!(
        "{} of the {total} frames in {} have no image (first: {}): they are left out",
        missing.len(),
        json::one_line(file),
        json::escape(first)
    ));
    Ok((found, missing))
}

/// What to say where some images have a mask and others do not.
pub(in crate::dataset) fn unmasked(frames: &[Frame]) -> Option<String> {
    let (all, unmasked) =
        (frames.len(), frames.iter().filter(|frame| frame.mask.is_none()).count());
    let some = (1..all).contains(&unmasked);
    some.then(|| format!("{unmasked} of {all} images have no mask: all their pixels count"))
}
