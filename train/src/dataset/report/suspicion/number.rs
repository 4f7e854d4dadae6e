//! How many photographs there are, and how far apart.

use pocketnerf_core::Camera;

use super::{Suspect, Suspicion};
use crate::cameras::{GAP, WIDE, spacing, widest_gap};
use crate::dataset::Split;

/// Fewer photographs to learn from are few: around something, and of something ahead.
const FEW: [usize; 2] = [10, 5];

/// `are_placed`: whether cameras look where they should, so that angles between them mean
/// something.
pub(super) fn find(suspect: &Suspect<'_, '_>, are_placed: bool) -> Option<Suspicion> {
    let poses = || suspect.of_split(Split::Train).map(|shot| shot.frame.pose);
    let (count, [around, ahead]) = (poses().count(), FEW);
    let least = if suspect.listing.forward_facing { ahead } else { around };
    if count == 0 {
        return None;
    }
    if count < least {
        return Some(Suspicion::new(
            "few",
            format!(
                "{count} photographs to learn from, expected at least {least}, better 50: most \
                 will be a guess; take more"
            ),
        ));
    }
    if !are_placed || suspect.listing.forward_facing {
        return None;
    }
    // Only poses count.
    let cameras: Vec<Camera> = poses().map(|pose| Camera::from_fov_x(1, 1, 1.0, pose)).collect();
    if let Some(angle) = spacing(&cameras).filter(|angle| *angle > WIDE) {
        return Some(Suspicion::new(
            "far-apart",
            format!(
                "photographs are {angle:.0} degrees from one to the next, expected at most {WIDE}: \
                 what lies between them is a guess; take more"
            ),
        ));
    }
    let gap = widest_gap(&cameras);
    (gap > GAP).then(|| {
        Suspicion::new(
            "gap",
            format!(
                "photographs leave a gap of {gap:.0} degrees between them, expected at most {GAP}: \
                 what is seen from there is a guess; take some there"
            ),
        )
    })
}
