//! Poses and photographs that are there more than once.

use super::super::shot::Shot;
use super::{Suspect, Suspicion};

pub(super) fn find(suspect: &Suspect<'_, '_>) -> Vec<Suspicion> {
    let mut found = Vec::new();
    let bits = |shot: &Shot<'_>| shot.frame.pose.map(f32::to_bits);
    let content = |shot: &Shot<'_>| shot.header.map(|header| header.content);
    let poses = again(suspect, |a, b| bits(a) == bits(b) && content(a) != content(b));
    // Where nearly all cameras are in one pose, something else is said.
    if !poses.is_empty() && 2 * poses.len() < suspect.shots.len() {
        found.push(Suspicion::new(
            "same-pose",
            format!(
                "{}; correct the poses or take the frames out",
                suspect.some("cameras with the pose of another, but another photograph", &poses)
            ),
        ));
    }
    let photos = again(suspect, |a, b| {
        content(a).is_some() && content(a) == content(b) && bits(a) != bits(b)
    });
    if !photos.is_empty() {
        found.push(Suspicion::new(
            "same-photo",
            format!(
                "{}; take the frames out, or give the photographs that belong there",
                suspect
                    .some("photographs that are the same as another, with another pose", &photos)
            ),
        ));
    }
    found
}

/// The frames that an earlier one is like.
fn again(suspect: &Suspect<'_, '_>, is_like: impl Fn(&Shot<'_>, &Shot<'_>) -> bool) -> Vec<usize> {
    let shots = &suspect.shots;
    (0..shots.len()).filter(|i| shots[..*i].iter().any(|s| is_like(s, shots[*i]))).collect()
}
