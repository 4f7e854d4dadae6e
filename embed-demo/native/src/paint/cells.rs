//! The cells of a model's occupancy grid, drawn as if they were solid.

use pocketnerf_core::occupancy::BLOCK;
use pocketnerf_core::space::{Piece, UnitMap};
use pocketnerf_core::{Model, Occupancy, Ray};

/// Cells along each side of a block.
const BLOCK_CELLS: f32 = BLOCK as f32;

/// Intersects rays with the cells of a model.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'m> {
    model: &'m Model<'m>,
    map: UnitMap,
    /// Cells along each axis.
    resolution: f32,
    /// Upper corner of the model's box, in cells.
    corner: [f32; 3],
}

/// Where a ray enters an occupied cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Distance along the ray in the space's own coordinates.
    pub t: f32,
    /// The axis that the face is perpendicular to.
    pub axis: usize,
    /// The cell.
    pub cell: [u32; 3],
}

impl<'m> Cells<'m> {
    /// The cells of a model; without occupancy, all of its box is occupied.
    #[must_use]
    pub fn new(model: &'m Model<'m>) -> Self {
        let map = model.space.unit_map();
        let resolution = model.occupancy.map_or(128, |occupancy| occupancy.resolution()) as f32;
        let corner = map.apply(model.space.bounds()[1]).map(|u| u * resolution);
        Self { model, map, resolution, corner }
    }

    /// The box around the occupied blocks, local coordinates.
    #[must_use]
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let all = self.model.space.bounds();
        let Some(occupancy) = &self.model.occupancy else { return all };
        let n = occupancy.resolution() / BLOCK;
        let (mut low, mut high) = ([n; 3], [0; 3]);
        let blocks = (0..n * n * n).map(|i| [i % n, i / n % n, i / (n * n)]);
        for block in blocks.filter(|[x, y, z]| occupancy.block(*x, *y, *z).is_some()) {
            for a in 0..3 {
                low[a] = low[a].min(block[a]);
                high[a] = high[a].max(block[a] + 1);
            }
        }
        if low[0] >= high[0] {
            return all;
        }
        let place = |a: usize, block: u32| {
            let cells = block as f32 * BLOCK_CELLS;
            (self.map.min[a] + cells / self.resolution / self.map.scale).clamp(all[0][a], all[1][a])
        };
        [[0, 1, 2].map(|a| place(a, low[a])), [0, 1, 2].map(|a| place(a, high[a]))]
    }

    /// The first occupied cell along a ray.
    #[must_use]
    pub fn first(&self, ray: &Ray) -> Option<Face> {
        let mut begin = 0.0;
        while let Some(Piece { local, end }) = self.model.space.piece(ray, begin) {
            let found = self.along(&local, [begin, end]);
            if found.is_some() || end == f32::INFINITY {
                return found;
            }
            begin = end;
        }
        None
    }

    /// The same along a part of a local ray.
    fn along(&self, ray: &Ray, part: [f32; 2]) -> Option<Face> {
        let per_unit = self.map.scale * self.resolution;
        let from = self.map.apply(ray.origin).map(|u| u * self.resolution);
        let speed = ray.direction.map(|d| d * per_unit);
        let ([mut t, end], mut axis) = self.inside(from, speed, part)?;
        // Slightly into the cell, so rounding does not select the one before.
        let nudge = 1e-3 / per_unit;
        while t + nudge < end {
            let at = [0, 1, 2].map(|a| from[a] + (t + nudge) * speed[a]);
            let cell = at.map(|v| v.max(0.0) as u32);
            let Some(occupancy) = &self.model.occupancy else {
                return Some(Face { t, axis, cell });
            };
            if occupancy.cell(cell[0], cell[1], cell[2]) {
                return Some(Face { t, axis, cell });
            }
            let (leaves, across) = leave(from, speed, cell, side(occupancy, cell));
            t = leaves.max(t + nudge);
            axis = across;
        }
        None
    }

    /// Where a part of a ray enters and leaves the model's box, and across which axis it enters.
    fn inside(
        &self,
        from: [f32; 3],
        speed: [f32; 3],
        [mut enters, mut leaves]: [f32; 2],
    ) -> Option<([f32; 2], usize)> {
        let mut axis = 2;
        for a in 0..3 {
            let ends = [-from[a] / speed[a], (self.corner[a] - from[a]) / speed[a]];
            let [first, last] = if speed[a] < 0.0 { [ends[1], ends[0]] } else { ends };
            // NaN, for a ray within a wall, compares false.
            if first > enters {
                (enters, axis) = (first, a);
            }
            leaves = leaves.min(last);
        }
        (enters < leaves).then_some(([enters, leaves], axis))
    }
}

/// Cells along each side of the empty cube around an empty cell.
fn side(occupancy: &Occupancy<'_>, [x, y, z]: [u32; 3]) -> f32 {
    match occupancy.block(x / BLOCK, y / BLOCK, z / BLOCK) {
        Some(_) => 1.0,
        None => BLOCK_CELLS,
    }
}

/// Where a ray leaves the cube with `side` cells a side around a cell, and across which axis.
fn leave(from: [f32; 3], speed: [f32; 3], cell: [u32; 3], side: f32) -> (f32, usize) {
    let mut first = (f32::INFINITY, 0);
    for a in 0..3 {
        let low = (cell[a] as f32 / side).floor() * side;
        let wall = if speed[a] < 0.0 { low } else { low + side };
        let t = (wall - from[a]) / speed[a];
        if t < first.0 {
            first = (t, a);
        }
    }
    first
}

/// Three shades, as if lit from above; every other cell and block is slightly darker.
#[must_use]
pub fn color(face: &Face) -> [f32; 3] {
    let light = [0.5, 0.7, 1.0][face.axis];
    let odd = |cells: u32| (face.cell.iter().map(|c| c / cells).sum::<u32>() % 2) as f32;
    [0.68, 0.82, 0.94].map(|c| c * light * (1.0 - 0.05 * odd(1)) * (1.0 - 0.12 * odd(BLOCK)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_core::Space;
    use pocketnerf_core::space::Contracted;

    #[test]
    fn finds_the_cell_of_the_golden_file() {
        let bytes = include_bytes!("../../../../tests/golden/hash-grid-f16.pnerf");
        let file = pocketnerf_formats::open(bytes).unwrap();
        let (model, cells) = (&file.model, Cells::new(&file.model));
        let occupancy = model.occupancy.unwrap();
        let [min, max] = model.space.bounds();
        let n = occupancy.resolution();
        let mut met = 0;
        // Straight down each column of cells: the topmost occupied one.
        for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
            let place = |a: usize, c: u32| min[a] + (c as f32 + 0.5) / n as f32 / cells.map.scale;
            let ray = Ray {
                origin: [place(0, x), place(1, y), max[2] + 1.0],
                direction: [0.0, 0.0, -1.0],
            };
            if place(0, x) > max[0] || place(1, y) > max[1] {
                continue;
            }
            // The box does not fill the cube.
            let within = (0..n).rev().filter(|z| (*z as f32) < cells.corner[2]);
            let expected = { within }.find(|z| occupancy.cell(x, y, *z));
            let found = cells.first(&ray);
            assert_eq!(found.map(|face| face.cell), expected.map(|z| [x, y, z]));
            assert!(found.is_none_or(|face| face.axis == 2));
            met += usize::from(found.is_some());
        }
        assert!(met > 0);
        let [low, high] = cells.bounds();
        assert!((0..3).all(|a| min[a] <= low[a] && low[a] < high[a] && high[a] <= max[a]));
    }

    #[test]
    fn bent_rays_meet_the_cells_of_all_their_pieces() {
        let bytes = include_bytes!("../../../../tests/golden/hash-grid-f16.pnerf");
        let file = pocketnerf_formats::open(bytes).unwrap();
        let space = Space::Contracted(Contracted { center: [0.5; 3], radius: 2.0 });
        let model = Model { space, ..file.model };
        let (cells, occupancy) = (Cells::new(&model), model.occupancy.unwrap());
        let [mut first, mut later, mut none] = [0; 3];
        for i in 0..600 {
            // Around the sphere, from three places.
            let (height, angle) = (0.99 - i as f32 / 300.0, 2.4 * i as f32);
            let across = (1.0 - height * height).max(0.0).sqrt();
            let direction = [across * angle.cos(), across * angle.sin(), height];
            let origin = [[0.6, 0.4, 0.3], [-0.9, 0.7, 2.1], [7.0, -3.0, 1.0]][i % 3];
            let ray = Ray { origin, direction };
            let found = cells.first(&ray);
            let until = found.map_or(f32::INFINITY, |face| face.t);
            let at = |t: f32| {
                let local = space.piece(&ray, t)?.local;
                let p = [0, 1, 2].map(|a| local.origin[a] + t * local.direction[a]);
                Some(cells.map.apply(p).map(|u| u * cells.resolution))
            };
            // Nothing is passed by, and there is something where it says so.
            for t in (0..).map(|k| k as f32 * 2e-3).take_while(|t| *t < until - 1e-3) {
                let Some([x, y, z]) = at(t).map(|at| at.map(|v| v as u32)) else { break };
                assert!(!occupancy.cell(x, y, z), "{t} of {until}, {ray:?}");
            }
            let Some(Face { t, cell, .. }) = found else {
                none += 1;
                continue;
            };
            let point = at(t + 1e-4).unwrap();
            let inside = |a: usize| (point[a] - cell[a] as f32 - 0.5).abs() < 0.51;
            assert!(
                occupancy.cell(cell[0], cell[1], cell[2]) && (0..3).all(inside),
                "{point:?} {cell:?}"
            );
            let is_first = t < space.piece(&ray, 0.0).unwrap().end;
            *(if is_first { &mut first } else { &mut later }) += 1;
        }
        assert!(first > 20 && later > 20 && none > 20, "{first} {later} {none}");
    }

    #[test]
    fn rays_that_go_nowhere_meet_nothing() {
        let bytes = include_bytes!("../../../../tests/golden/hash-grid-f16.pnerf");
        let file = pocketnerf_formats::open(bytes).unwrap();
        let cells = Cells::new(&file.model);
        let aside = Ray { origin: [1e3, 0.0, 0.0], direction: [1.0, 0.0, 0.0] };
        assert_eq!(cells.first(&aside), None);
        let nowhere = Ray { origin: [f32::NAN; 3], direction: [1.0, 0.0, 0.0] };
        let _ = cells.first(&nowhere);
    }
}
