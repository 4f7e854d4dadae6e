//! Space that is empty, because points of the scene were seen through it.
//!
//! A photograph in which a point was found tells that nothing is between its camera and the
//! point. Where few photographs look, training may put fog before a camera that explains its
//! photograph as well as the scene does; what many lines of sight cross cannot hold any.

use pocketnerf_core::Space;

use crate::dataset::View;

/// Cells along an axis. Coarser than those of training, so that lines cross most of them.
const RESOLUTION: usize = 64;
/// Fewer lines through a cell may be those of points that are wrong.
const LINES: u8 = 2;
/// A line ends so many cells before its point: surfaces are known no better.
const BEFORE: f32 = 2.0;
/// Cells from one step along a line to the next.
const STEP: f32 = 0.5;

/// A line of sight: from a camera to a point that its photograph shows.
pub(super) struct Sight {
    from: [f32; 3],
    to: [f32; 3],
}

/// All lines of sight.
pub(super) fn sights(views: &[View]) -> Vec<Sight> {
    let of = |view: &View| {
        let from = view.camera.position();
        view.shows.iter().map(move |to| Sight { from, to: *to }).collect::<Vec<_>>()
    };
    views.iter().flat_map(of).collect()
}

/// Leaves out the cells, of `resolution`³ over the cube of the space, that are known to be empty:
/// lines of sight cross them and all their neighbours. One that grazes a surface empties none
/// of it.
pub(super) fn carve(space: &Space, resolution: u32, sights: &[Sight], cells: &mut Vec<u32>) {
    if sights.is_empty() {
        return;
    }
    let crossed = crossed(space, sights);
    let around = |c: usize| c.saturating_sub(1)..=(c + 1).min(RESOLUTION - 1);
    let is_empty = |at: [usize; 3]| {
        let [x, y, z] = at.map(around);
        let mut all = z.flat_map(|z| y.clone().map(move |y| [y, z]));
        all.all(|[y, z]| x.clone().all(|x| crossed[index([x, y, z])] >= LINES))
    };
    let n = resolution as usize;
    cells.retain(|cell| {
        let cell = *cell as usize;
        let at = [cell % n, cell / n % n, cell / (n * n)];
        !is_empty(at.map(|c| c * RESOLUTION / n))
    });
}

/// How many lines cross each cell; more than 255 count as that.
fn crossed(space: &Space, sights: &[Sight]) -> Vec<u8> {
    let (map, n) = (space.unit_map(), RESOLUTION as f32);
    let mut crossed = vec![0u8; RESOLUTION.pow(3)];
    for Sight { from, to } in sights {
        let [from, to] = [from, to].map(|p| glam::Vec3::from(map.apply(*p)) * n);
        let way = to - from;
        let length = way.length();
        let direction = way / length;
        let mut last = usize::MAX;
        let steps = ((length - BEFORE) / STEP).max(0.0) as usize;
        for step in 0..=steps {
            let at = from + direction * (step as f32 * STEP);
            if at.min_element() < 0.0 || at.max_element() >= n {
                continue;
            }
            let cell = index(at.to_array().map(|c| c as usize));
            if cell != last {
                crossed[cell] = crossed[cell].saturating_add(1);
                last = cell;
            }
        }
    }
    crossed
}

fn index([x, y, z]: [usize; 3]) -> usize {
    x + RESOLUTION * (y + RESOLUTION * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a box of side 64, whose coarse cells are 1 wide, each camera looks along x at a
    /// grid of points 1 apart, with y and z from 20.5 to 40.5, at x = 50.5.
    #[test]
    fn what_is_seen_through_is_empty() {
        let space = Space::Box { min: [0.0; 3], max: [64.0; 3] };
        let line = |y: f32, z: f32| Sight { from: [-5.0, y, z], to: [50.5, y, z] };
        let all = |i: f32| (20..=40).map(move |z| line(i, z as f32 + 0.5));
        let sights = || (20..=40).flat_map(|y| all(y as f32 + 0.5));
        let carved = |sights: Vec<Sight>| {
            let mut cells: Vec<u32> = (0..128u32.pow(3)).collect();
            carve(&space, 128, &sights, &mut cells);
            cells
        };
        assert_eq!(carved(sights().collect()).len(), 128usize.pow(3));
        let left = carved(sights().chain(sights()).collect());
        // Lines end at 48.5; without the outermost cells of what is crossed, but those at the
        // side of the box: x from 0 to 47, y and z from 21 to 39, eight fine cells each.
        assert_eq!(128usize.pow(3) - left.len(), 48 * 19 * 19 * 8);
        let has = |x: u32, y: u32, z: u32| left.contains(&(x + 128 * (y + 128 * z)));
        assert!(!has(0, 60, 60) && !has(95, 60, 60) && has(96, 60, 60));
        assert!(has(60, 41, 60) && !has(60, 42, 60) && !has(60, 79, 60) && has(60, 80, 60));
    }
}
