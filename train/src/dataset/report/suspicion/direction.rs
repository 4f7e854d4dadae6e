//! Where cameras look: all of them, and some unlike the others.

use glam::{DMat4, DVec3};

use super::{Sight, Suspect, Suspicion, place};
use crate::cameras::nearest_to_axes;

/// Cameras within this angle of a point look at it, degrees.
const AT: f64 = 45.0;
/// Share of the cameras that must look at a point for it to be what they look at.
const MOST: f64 = 0.5;
/// The same for another convention to be taken for the poses' own, and within which angle.
const NEARLY_ALL: f64 = 0.9;
const CLOSELY: f64 = 20.0;
/// Cameras whose mean direction is longer than this look forward: where their axes meet means
/// little.
const FORWARD: f64 = 0.7;
/// Fewer cameras tell nothing.
const FEWEST: usize = 4;
/// Where four in five cameras look at the point within `FEW`, one that is `AWAY` from it is wrong,
/// degrees.
const FEW: f64 = 30.0;
const AWAY: f64 = 75.0;
/// Share of the cameras that must look at a box that is given.
const AT_BOX: f64 = 0.5;

/// Another convention: its name, what to do, and poses as they would be here.
type Convention = (&'static str, &'static str, fn(DMat4) -> DMat4);

const CONVENTIONS: [Convention; 5] = [
    ("OpenCV's (x right, y down, z forward)", "negate the second and third column", opencv),
    ("world-to-camera", "invert the matrices", |pose| pose.inverse()),
    (
        "world-to-camera, OpenCV's",
        "invert the matrices, then negate the second and third column",
        |pose| opencv(pose.inverse()),
    ),
    ("those of cameras that look along +x (y left, z up)", "take as columns -y, z, -x", |pose| {
        columns(pose, [-pose.y_axis, pose.z_axis, -pose.x_axis])
    }),
    ("those of cameras that look along +y (x right, z up)", "take as columns x, z, -y", |pose| {
        columns(pose, [pose.x_axis, pose.z_axis, -pose.y_axis])
    }),
];

fn opencv(pose: DMat4) -> DMat4 {
    columns(pose, [pose.x_axis, -pose.y_axis, -pose.z_axis])
}

fn columns(pose: DMat4, [x, y, z]: [glam::DVec4; 3]) -> DMat4 {
    DMat4::from_cols(x, y, z, pose.w_axis)
}

pub(super) fn find(suspect: &Suspect<'_, '_>) -> Vec<Suspicion> {
    let training = suspect.training();
    let at = nearest_to_axes(&training.poses());
    if let Some(convention) = convention(&training, at) {
        return vec![convention];
    }
    if let Some(placed) = place::find(&training, at) {
        return vec![placed];
    }
    let mut found = Vec::new();
    if let Some(at) = at.filter(|_| !suspect.listing.forward_facing) {
        let away = away(suspect, &training, at);
        found.extend(away.or_else(|| place::lost(suspect, &training, at)));
    }
    found.extend(beside_box(suspect));
    found
}

/// Poses of another convention: by it, nearly all cameras look at one point, and as they are, few.
fn convention(training: &Suspect<'_, '_>, at: Option<DVec3>) -> Option<Suspicion> {
    let is_fixed = ["colmap", "llff"].contains(&training.listing.format);
    let (poses, sights) = (training.poses(), training.sights());
    let share = share_at(&sights, at, AT);
    if share >= MOST || is_fixed || sights.len() < FEWEST {
        return None;
    }
    let (name, what, _) = CONVENTIONS.iter().find(|(.., change)| {
        let poses: Vec<_> = poses.iter().map(|pose| changed(pose, *change)).collect();
        let sights: Vec<_> = poses.iter().map(Sight::of).collect();
        let mean = sights.iter().map(|s| s.forward).sum::<DVec3>() / sights.len() as f64;
        let at = nearest_to_axes(&poses);
        mean.length() < FORWARD && share_at(&sights, at, CLOSELY) >= NEARLY_ALL
    })?;
    Some(Suspicion::new(
        "poses-convention",
        format!(
            "{:.0} % of the cameras look at the point nearest to their axes, expected most of them: \
             the poses look like {name}; {what}, unless the photographs were taken from one place \
             outwards",
            100.0 * share
        ),
    ))
}

fn changed(pose: &[f32; 16], change: fn(DMat4) -> DMat4) -> [f32; 16] {
    let rows = pose.map(f64::from);
    let other = change(DMat4::from_cols_array(&rows).transpose());
    other.transpose().to_cols_array().map(|x| x as f32)
}

/// The share of the cameras that look at a point within an angle.
fn share_at(sights: &[Sight], point: Option<DVec3>, angle: f64) -> f64 {
    let Some(point) = point else { return 1.0 };
    let looking = sights.iter().filter(|sight| sight.angle_to(point) < angle).count();
    looking as f64 / sights.len().max(1) as f64
}

/// Cameras that look away from what nearly all others look at.
fn away(suspect: &Suspect<'_, '_>, training: &Suspect<'_, '_>, at: DVec3) -> Option<Suspicion> {
    if training.shots.len() < FEWEST {
        return None;
    }
    // Without those, the point is where the others look.
    let (poses, sights) = (training.poses(), training.sights());
    let others = (0..poses.len()).filter(|i| sights[*i].angle_to(at) < AT).map(|i| poses[i]);
    let at = nearest_to_axes(&others.collect::<Vec<_>>())?;
    let angles = |sights: &[Sight]| -> Vec<f64> { sights.iter().map(|s| s.angle_to(at)).collect() };
    if super::at(angles(&sights).into_iter(), 0.8) > FEW {
        return None;
    }
    let angles = angles(&suspect.sights());
    let which: Vec<usize> = (0..angles.len()).filter(|i| angles[*i] > AWAY).collect();
    (!which.is_empty()).then(|| {
        Suspicion::new(
            "looks-away",
            format!(
                "{}; correct the poses or take the frames out",
                suspect.some("cameras that look away from what the others look at", &which)
            ),
        )
    })
}

/// A box that the dataset gives, and that hardly any camera looks at.
fn beside_box(suspect: &Suspect<'_, '_>) -> Option<Suspicion> {
    let corners = suspect.listing.aabb?;
    let share = super::super::look::share_looking_at(&suspect.poses(), corners);
    (share < AT_BOX).then(|| {
        Suspicion::new(
            "box",
            format!(
                "{:.0} % of the cameras look at the box that the dataset gives, expected most of \
                 them: correct it, or give --aabb",
                100.0 * share
            ),
        )
    })
}
