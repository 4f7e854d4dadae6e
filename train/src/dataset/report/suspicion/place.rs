//! Where cameras are.

use glam::DVec3;

use super::{Suspect, Suspicion, shown};

/// Cameras as near to each other as this, as a share of their distance from the origin, are in
/// one place.
const ONE_PLACE: f64 = 1e-6;
/// The same as a share of the nearest depth that is known, or of the box.
const BASELINE: f64 = 0.005;
/// Median distances from what is looked at: the program has been measured from 0.004 to 4,000.
const SCALE: [f64; 2] = [1e-3, 1e4];
/// A scene that is so many times as far from the origin as from its cameras has few digits left.
const FAR_OFF: f64 = 1e4;
/// A camera that is so many times as far from what is looked at as the median is lost.
const LOST: f64 = 20.0;

/// Cameras in one place or nearly, and units that lose digits.
pub(super) fn find(suspect: &Suspect<'_, '_>, at: Option<DVec3>) -> Option<Suspicion> {
    let positions = positions(suspect);
    if positions.len() < 2 {
        return None;
    }
    let middle = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let spread = positions.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    if spread <= ONE_PLACE * middle.length() {
        return Some(Suspicion::new(
            "one-place",
            format!(
                "all {} cameras are in one place ({} units apart at most): nothing has a depth; \
                 move between photographs, or correct the poses (are they world-to-camera?)",
                positions.len(),
                shown(2.0 * spread)
            ),
        ));
    }
    if let Some(depth) = depth(suspect).filter(|depth| spread < BASELINE * depth) {
        return Some(Suspicion::new(
            "baseline",
            format!(
                "cameras are {} units apart at most, and the scene is {} away or large: next to \
                 nothing has a depth; move more between photographs, or correct the scale of the \
                 poses",
                shown(2.0 * spread),
                shown(depth)
            ),
        ));
    }
    let distance = match at.filter(|_| !suspect.listing.forward_facing) {
        Some(at) => distance(&positions, at),
        None => spread,
    };
    scale(distance).or_else(|| far_off(middle, distance))
}

/// Cameras much farther from what is looked at than usual.
pub(super) fn lost(
    suspect: &Suspect<'_, '_>,
    training: &Suspect<'_, '_>,
    at: DVec3,
) -> Option<Suspicion> {
    let most = LOST * distance(&positions(training), at);
    let all = positions(suspect);
    let which: Vec<usize> = (0..all.len()).filter(|i| all[*i].distance(at) > most).collect();
    (!which.is_empty()).then(|| {
        Suspicion::new(
            "lost-camera",
            format!(
                "{}; correct the poses or take the frames out",
                suspect.some("cameras more than 20 times as far away as others", &which)
            ),
        )
    })
}

fn positions(suspect: &Suspect<'_, '_>) -> Vec<DVec3> {
    suspect.sights().iter().map(|sight| sight.position).collect()
}

/// The median.
fn distance(positions: &[DVec3], at: DVec3) -> f64 {
    super::at(positions.iter().map(|p| p.distance(at)), 0.5)
}

/// How far away or large the dataset says that the scene is.
fn depth(suspect: &Suspect<'_, '_>) -> Option<f64> {
    let side = |[min, max]: [[f32; 3]; 2]| (0..3).map(|a| max[a] - min[a]).fold(0.0, f32::max);
    let near = suspect.listing.bounds.map(|[near, _]| near);
    near.or(suspect.listing.aabb.map(side)).map(f64::from)
}

fn scale(distance: f64) -> Option<Suspicion> {
    let [least, most] = SCALE;
    let (what, times) = match (distance < least, distance > most) {
        (true, _) => ("small", 1.0 / distance),
        (_, true) => ("large", 1.0 / distance),
        _ => return None,
    };
    Some(Suspicion::new(
        "scale",
        format!(
            "cameras are {} units from what they look at, expected {least} to {most}: units this \
             {what} lose digits; multiply the positions by about {}",
            shown(distance),
            shown(times)
        ),
    ))
}

fn far_off(middle: DVec3, distance: f64) -> Option<Suspicion> {
    (middle.length() > FAR_OFF * distance).then(|| {
        Suspicion::new(
            "far-off",
            format!(
                "cameras are {} units from the origin and {} from what they look at: positions \
                 lose digits; move the scene to the origin",
                shown(middle.length()),
                shown(distance)
            ),
        )
    })
}
