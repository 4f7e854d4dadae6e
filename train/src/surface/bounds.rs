//! The box around what cameras see.

use glam::Vec3;
use pocketnerf_core::Model;

use super::look::Seen;

/// One pixel in so many is looked at.
const EVERY: usize = 7;
/// This share of the points may lie outside, on each side: fog, and what is seen by few.
const OUTSIDE: f32 = 0.002;
/// Room on each side, a share of the longest side.
const ROOM: f32 = 0.02;

/// Smallest and largest corner; `None` where nothing is seen, or not within `crop`.
pub(super) fn of(
    seen: &[Seen],
    model: &Model<'_>,
    crop: Option<[[f32; 3]; 2]>,
) -> Option<[Vec3; 2]> {
    let within = crop.or_else(|| model.space.scene_box());
    let [least, most] = within.map_or([Vec3::MIN, Vec3::MAX], |corners| corners.map(Vec3::from));
    let mut axes = [const { Vec::new() }; 3];
    for seen in seen {
        for point in (0..seen.depth.len()).step_by(EVERY).filter_map(|pixel| seen.point(pixel)) {
            if point.cmpge(least).all() && point.cmple(most).all() {
                axes.iter_mut().zip(point.to_array()).for_each(|(axis, x)| axis.push(x));
            }
        }
    }
    let mut corners = [Vec3::ZERO; 2];
    for (axis, values) in axes.iter_mut().enumerate() {
        let last = values.len().checked_sub(1)?;
        values.sort_unstable_by(f32::total_cmp);
        let outside = (OUTSIDE * last as f32) as usize;
        corners[0][axis] = values[outside];
        corners[1][axis] = values[last - outside];
    }
    let [low, high] = corners;
    let room = ROOM * (high - low).max_element();
    (room > 0.0).then(|| [(low - room).max(least), (high + room).min(most)])
}
