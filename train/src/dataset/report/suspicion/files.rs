//! Images and masks that are missing, unreadable, turned, or of another shape or size.

use super::super::shot::Shot;
use super::{Suspect, Suspicion};
use crate::dataset::turn::Turn;

pub(super) fn find(suspect: &Suspect<'_, '_>) -> Vec<Suspicion> {
    let mut found = Vec::new();
    let mut add = |kind, which: &[usize], what: &str, then: &str| {
        if !which.is_empty() {
            let text = format!("{}; {then}", suspect.some(what, which));
            found.push(Suspicion::new(kind, text));
        }
    };
    let missing = suspect.which(|shot| shot.file.is_none());
    add("missing", &missing, "images that are missing", "add them or take their frames out");
    let unreadable = suspect.which(|shot| shot.file.is_some() && shot.header.is_none());
    add("unreadable", &unreadable, "images that are unreadable or cut off", "copy them again");
    // COLMAP reads images as they are stored, too.
    let by_colmap = ["colmap", "llff"].contains(&suspect.listing.format);
    let turned = suspect.which(|shot| !by_colmap && shot.turn == Turn::Untold);
    add(
        "turned",
        &turned,
        "images to be shown turned or mirrored (EXIF)",
        "they are read as they are stored; where the cameras are those of upright images, turn \
         the pixels, as `mogrify -auto-orient` does",
    );
    let is_misshapen = |shot: &Shot<'_>| shot.header.is_some() && shot.camera.is_none();
    let mut misshapen = suspect.which(is_misshapen);
    misshapen.retain(|i| !turned.contains(i));
    add(
        "misshapen",
        &misshapen,
        "images of another shape than their cameras",
        "correct w and h or the images",
    );
    let masks = |shot: &Shot<'_>| {
        let mask = shot.frame.mask.as_ref();
        mask.is_some_and(|mask| !shot.folder.join(&mask.path).is_file())
    };
    let masks = suspect.which(masks);
    add(
        "mask-missing",
        &masks,
        "images whose masks are missing",
        "add them or take their names out",
    );
    found.extend(sizes(suspect));
    found
}

/// Images of other sizes than the first, though they share a camera, or their cameras have one
/// size.
fn sizes(suspect: &Suspect<'_, '_>) -> Option<Suspicion> {
    let known = |shot: &Shot<'_>| {
        let header = shot.header.filter(|_| shot.camera.is_some())?;
        Some((header.size, shot.frame.intrinsics))
    };
    let (usual, intrinsics) = usual(suspect.shots.iter().filter_map(|shot| known(shot)))?;
    let other = suspect.which(|shot| {
        known(shot).is_some_and(|(size, own)| size != usual && own.size == intrinsics.size)
    });
    let of_one_camera = intrinsics.shared || intrinsics.size.is_some();
    let [width, height] = usual;
    let first = suspect.shots.get(*other.first()?)?.header?.size;
    of_one_camera.then(|| {
        Suspicion::new(
            "sizes",
            format!(
                "{}, {}x{} pixels, the others have {width}x{height}; give images of one size",
                suspect.some("images of another size, though they share a camera", &other),
                first[0],
                first[1]
            ),
        )
    })
}

/// The most frequent size, the first of several.
fn usual<T: Copy>(sizes: impl Iterator<Item = ([u32; 2], T)>) -> Option<([u32; 2], T)> {
    let mut counts: Vec<([u32; 2], T, usize)> = Vec::new();
    for (size, with) in sizes {
        match counts.iter_mut().find(|(known, ..)| *known == size) {
            Some((.., count)) => *count += 1,
            None => counts.push((size, with, 1)),
        }
    }
    let most = counts.iter().map(|(.., count)| *count).max()?;
    counts.into_iter().find(|(.., count)| *count == most).map(|(size, with, _)| (size, with))
}
