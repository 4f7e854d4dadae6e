//! Where a scene is, by its points and cameras.

use glam::DVec3;
use rayon::prelude::*;

use crate::cameras::nearest_to_axes;
use crate::dataset::listing::{Frame, Listing};
use crate::lens::Lens;

/// An image that shows fewer points says nothing of depths, and fewer points nothing of a box.
pub(in crate::dataset) const FEWEST: usize = 20;
/// The share of depths, and of coordinates, that may be wrong on each side.
pub(in crate::dataset) const WRONG: f64 = 0.01;
/// The scene's box goes beyond its points by this share of their box on each side: plain walls
/// have few points.
const MARGIN: f64 = 0.5;
/// But not farther from what cameras look at than so many median depths: what is beyond is seen on
/// the faces, and a larger box has coarser cells.
const FARTHEST: f64 = 2.5;
/// Of more points than this, evenly spread ones count.
const ENOUGH: usize = 20_000;
/// Panoramas show what is around: half of the side of its cube, in the distance of the farthest
/// camera from the middle of all.
const SURROUNDINGS: f64 = 2.5;

/// What points say.
#[derive(Debug)]
pub(in crate::dataset) struct Around {
    /// Nearest and farthest depth.
    pub(in crate::dataset) bounds: [f32; 2],
    /// The box around them.
    pub(in crate::dataset) reach: Option<[[f32; 3]; 2]>,
}

/// What points say of which it is not known who sees them: each camera sees those within its
/// picture. `None` where no image shows enough.
pub(in crate::dataset) fn around(points: &[DVec3], frames: &[Frame]) -> Option<Around> {
    let step = points.len().div_ceil(ENOUGH).max(1);
    let few: Vec<DVec3> = points.iter().copied().step_by(step).collect();
    let depths: Vec<Vec<f64>> = frames.par_iter().filter_map(|frame| depths(frame, &few)).collect();
    let ends = depths.iter().map(|depths| [at(depths, WRONG), at(depths, 1.0 - WRONG)]);
    let near = ends.clone().map(|[near, _]| near).reduce(f64::min)?;
    let far = ends.map(|[_, far]| far).reduce(f64::max)?;
    let mut medians: Vec<f64> = depths.iter().map(|depths| at(depths, 0.5)).collect();
    medians.sort_by(f64::total_cmp);
    let poses: Vec<[f32; 16]> = frames.iter().map(|frame| frame.pose).collect();
    let center = nearest_to_axes(&poses).unwrap_or_else(|| middle(frames));
    let reach = reach(&few, center, FARTHEST * at(&medians, 0.5));
    Some(Around { bounds: [near as f32, far as f32], reach })
}

/// The depths of what a frame shows, sorted; `None` where they are too few or the size of its
/// picture is not known.
fn depths(frame: &Frame, points: &[DVec3]) -> Option<Vec<f64>> {
    let size = frame.intrinsics.size?;
    let camera = frame.intrinsics.camera(size.map(|side| side as u32), frame.pose)?;
    let [position, back] = [3, 2].map(|c| {
        DVec3::new(frame.pose[c].into(), frame.pose[4 + c].into(), frame.pose[8 + c].into())
    });
    let depth = |point: &DVec3| {
        let away = position - *point;
        let depth =
            if frame.lens == Lens::Equirectangular { away.length() } else { away.dot(back) };
        let [x, y] = frame.lens.project(&camera, point.as_vec3().to_array())?;
        let is_inside = (0.0..size[0] as f32).contains(&x) && (0.0..size[1] as f32).contains(&y);
        (is_inside && depth > 0.0).then_some(depth)
    };
    let mut depths: Vec<f64> = points.iter().filter_map(depth).collect();
    depths.sort_by(f64::total_cmp);
    (depths.len() >= FEWEST).then_some(depths)
}

/// The box around all but the outermost points along each axis, and its margin, no farther than
/// that from a point.
pub(in crate::dataset) fn reach(
    points: &[DVec3],
    center: DVec3,
    farthest: f64,
) -> Option<[[f32; 3]; 2]> {
    if points.len() < FEWEST {
        return None;
    }
    let sides = [0, 1, 2].map(|a| {
        let mut along: Vec<f64> = points.iter().map(|point| point[a]).collect();
        along.sort_by(f64::total_cmp);
        let [low, high] = [at(&along, WRONG), at(&along, 1.0 - WRONG)];
        let margin = MARGIN * (high - low);
        [(low - margin).max(center[a] - farthest), (high + margin).min(center[a] + farthest)]
    });
    let is_box = sides.iter().all(|[low, high]| high - low > 1e-3);
    is_box.then(|| [0, 1].map(|end| sides.map(|side| side[end] as f32)))
}

/// The value of sorted numbers below which such a share of them lies.
pub(in crate::dataset) fn at(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}

/// Gives panoramas a box where nothing else does: they look at no point.
pub(in crate::dataset) fn surround(listing: &mut Listing) {
    let is_panorama = |frame: &Frame| frame.lens == Lens::Equirectangular;
    let is_known = listing.aabb.is_some() || listing.reach.is_some();
    if is_known || !listing.frames.iter().all(is_panorama) {
        return;
    }
    let center = middle(&listing.frames);
    let distances = listing.frames.iter().map(|frame| position(frame).distance(center));
    let farthest = distances.fold(0.0, f64::max);
    let half = if farthest > 1e-3 { SURROUNDINGS * farthest } else { 1.0 };
    listing.reach = Some([-half, half].map(|half| (center + half).as_vec3().to_array()));
    listing.notes.push(format!(
        "panoramas do not tell how far the scene reaches: {half:.3} to each side of their middle is \
         taken; give --aabb where you know better"
    ));
}

fn position(frame: &Frame) -> DVec3 {
    DVec3::new(frame.pose[3].into(), frame.pose[7].into(), frame.pose[11].into())
}

fn middle(frames: &[Frame]) -> DVec3 {
    frames.iter().map(position).sum::<DVec3>() / frames.len().max(1) as f64
}
