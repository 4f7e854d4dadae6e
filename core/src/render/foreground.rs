//! How near anything is in each square of a tile's pixels: occupied cells, cast
//! onto the picture before any ray.
//!
//! Rays of a square in which nothing is are not cast, and the others begin where
//! something may be. Neither changes a picture: what is cast is larger than what is
//! there.

use core::ops::Range;

use glam::{Mat3, Vec3};

use crate::occupancy::{BLOCK, BLOCK_BYTES};
use crate::render::Tile;
use crate::{Camera, Model, Occupancy, Space};

/// Depths of a tile's squares of pixels: along the camera's axis, in its units.
pub(super) struct Foreground<'s> {
    depths: &'s mut [f32],
    /// Squares in a row.
    columns: u32,
    /// Pixels along a side, as the exponent of a power of two.
    side_log2: u32,
    /// Depth of a unit vector in scene space.
    pub(super) axis: [f32; 3],
}

/// Pixels of a tile from which casting cells takes less time than casting rays.
const WORTH_IT: usize = 2048;
/// Pixels along the sides of squares at least.
const LEAST_SIDE_LOG2: u32 = 2;

impl<'s> Foreground<'s> {
    /// Anything may be anywhere.
    pub(super) fn unknown(depths: &'s mut [f32]) -> Self {
        Self { depths: &mut depths[..0], columns: 0, side_log2: 0, axis: [0.0; 3] }
    }

    /// What a camera sees of a model in a tile of which every `spacing`-th pixel is
    /// rendered; nothing is known where that is not worth its time.
    pub(super) fn of(
        model: &Model<'_>,
        camera: &Camera,
        tile: Tile,
        spacing: u32,
        depths: &'s mut [f32],
    ) -> Self {
        let worth_it = tile.pixels() / (spacing as usize).pow(2) >= WORTH_IT;
        let (Some(occupancy), true) = (model.occupancy, worth_it) else {
            return Self::unknown(depths);
        };
        let Some(view) = View::new(model.space, &occupancy, camera, tile) else {
            return Self::unknown(depths);
        };
        let squares = |side_log2: u32| {
            let along = |n: u32| n.div_ceil(1 << side_log2);
            (along(tile.width), along(tile.width) as usize * along(tile.height) as usize)
        };
        let mut side_log2 = LEAST_SIDE_LOG2;
        while squares(side_log2).1 > depths.len() {
            side_log2 += 1;
        }
        let (columns, n) = squares(side_log2);
        let mut foreground = Self { depths: &mut depths[..n], columns, side_log2, axis: view.axis };
        foreground.depths.fill(f32::INFINITY);
        let blocks = occupancy.resolution() / BLOCK;
        foreground.cast(&view, &occupancy, [0; 3], blocks.next_power_of_two());
        foreground
    }

    /// Whether anything is known.
    pub(super) fn is_known(&self) -> bool {
        !self.depths.is_empty()
    }

    /// The depth in front of which nothing is on a pixel's ray, infinite where
    /// nothing is at all.
    #[inline(always)]
    pub(super) fn depth(&self, [x, y]: [u32; 2]) -> f32 {
        let square = (y >> self.side_log2) * self.columns + (x >> self.side_log2);
        self.depths.get(square as usize).copied().unwrap_or(0.0)
    }

    /// Casts the occupied cells of a cube of blocks, `side` a power of two, those in
    /// front first.
    fn cast(&mut self, view: &View, occupancy: &Occupancy<'_>, first: [u32; 3], side: u32) {
        let [x, y, z] = first;
        if occupancy.empty_blocks(first) >= side {
            return;
        }
        let corner = first.map(|c| c * BLOCK);
        let Some(outline) = view.outline(corner, side * BLOCK) else { return };
        if self.is_hidden(&outline) {
            return;
        }
        if side > 1 {
            view.each_half(|[i, j, k]| {
                let half = side / 2;
                self.cast(view, occupancy, [x + i * half, y + j * half, z + k * half], half);
            });
        } else if let Some(cells) = occupancy.block(x, y, z) {
            self.cast_block(view, corner, cells, &outline);
        }
    }

    fn cast_block(
        &mut self,
        view: &View,
        [x, y, z]: [u32; 3],
        cells: &[u8; BLOCK_BYTES],
        outline: &Outline,
    ) {
        const HALF: u32 = BLOCK / 2;
        let is_small = |[first, last]: [u32; 2]| last - first < 2 << self.side_log2;
        if is_small(outline.columns) && is_small(outline.rows) {
            self.mark(outline);
            return;
        }
        let layers = cells.as_chunks::<8>().0;
        view.each_half(|[i, j, k]| {
            let four = &layers[(k * HALF) as usize..][..HALF as usize];
            let all = four.iter().fold(0, |all, layer| all | u64::from_le_bytes(*layer));
            if all >> (8 * HALF * j + HALF * i) & 0x0f0f_0f0f != 0 {
                let corner = [x + i * HALF, y + j * HALF, z + k * HALF];
                if let Some(outline) = view.outline(corner, HALF) {
                    self.mark(&outline);
                }
            }
        });
    }

    /// Whether there is something in front of it everywhere.
    fn is_hidden(&self, outline: &Outline) -> bool {
        self.rows(outline).all(|row| self.depths[row].iter().all(|depth| *depth <= outline.depth))
    }

    fn mark(&mut self, outline: &Outline) {
        for row in self.rows(outline) {
            for depth in &mut self.depths[row] {
                *depth = depth.min(outline.depth);
            }
        }
    }

    /// The squares of an outline, row after row.
    fn rows(&self, outline: &Outline) -> impl Iterator<Item = Range<usize>> + use<> {
        let [left, right] = outline.columns.map(|x| (x >> self.side_log2) as usize);
        let [top, bottom] = outline.rows.map(|y| (y >> self.side_log2) as usize);
        let columns = self.columns as usize;
        (top..=bottom).map(move |row| row * columns + left..row * columns + right + 1)
    }
}

/// Pixels of the tile, first and last, and how near.
struct Outline {
    columns: [u32; 2],
    rows: [u32; 2],
    depth: f32,
}

/// From cells to pixels of a tile.
struct View {
    /// Where the grid's corner lies: right, up, and depth.
    corner: Vec3,
    /// How far it is from there to the next cell along each axis.
    cell: [Vec3; 3],
    /// How far a cell reaches to both sides of its middle.
    reach: Vec3,
    /// Added to half the side of a cube, in cells: the rounding of rays and their points.
    rounding: f32,
    /// Depth of a unit vector in scene space.
    axis: [f32; 3],
    focal: [f32; 2],
    /// Principal point, pixels from the tile's corner.
    center: [f32; 2],
    /// Of the tile.
    size: [u32; 2],
}

impl View {
    /// `None` for cameras that see no picture, and where cells are not cubes in it.
    fn new(space: Space, occupancy: &Occupancy<'_>, camera: &Camera, tile: Tile) -> Option<Self> {
        let m = &camera.camera_to_world;
        let column = |c: usize| Vec3::new(m[c], m[4 + c], m[8 + c]);
        // A pixel's direction is a sum of right, up and forwards.
        let forwards = -column(2);
        let to_camera = Mat3::from_cols(column(0), column(1), forwards).inverse();
        let (Some([min, max]), map) = (space.scene_box(), space.unit_map()) else { return None };
        let side = 1.0 / (map.scale * occupancy.resolution() as f32);
        let (eye, min) = (Vec3::from(camera.position()), Vec3::from(min));
        let corner = to_camera * (min - eye);
        let cell = [0, 1, 2].map(|a| to_camera.col(a) * side);
        let reach = cell[0].abs() + cell[1].abs() + cell[2].abs();
        let largest = eye.abs().max(min.abs()).max(Vec3::from(max).abs()).max_element();
        let rounding = 0.01 + 64.0 * f32::EPSILON * largest / side;
        let center = [camera.center[0] - tile.x as f32, camera.center[1] - tile.y as f32];
        let sound = corner.is_finite() && reach.is_finite() && rounding.is_finite();
        let sound = sound && reach.min_element() > 0.0;
        let finite = camera.focal.iter().chain(&center).all(|v| v.is_finite());
        (sound && finite).then(|| Self {
            corner,
            cell,
            reach,
            rounding,
            axis: to_camera.row(2).to_array(),
            focal: camera.focal,
            center,
            size: [tile.width, tile.height],
        })
    }

    /// Calls `cast` for the eight halves of a cube, those in front first.
    fn each_half(&self, mut cast: impl FnMut([u32; 3])) {
        let back = self.cell.map(|cell| u32::from(cell.z < 0.0));
        for half in 0..8 {
            cast([0, 1, 2].map(|a| (half >> a & 1) ^ back[a]));
        }
    }

    /// Where the cube of cells from a corner on is seen, `None` where it is not.
    #[inline(never)]
    fn outline(&self, corner: [u32; 3], side: u32) -> Option<Outline> {
        let half = 0.5 * side as f32;
        let [x, y, z] = corner.map(|c| c as f32 + half);
        let middle = self.corner + self.cell[0] * x + self.cell[1] * y + self.cell[2] * z;
        let reach = self.reach * (half + self.rounding);
        let (near, far) = (middle.z - reach.z, middle.z + reach.z);
        if far <= 0.0 {
            return None;
        }
        if near <= 0.01 * reach.z {
            // Around the camera, or all but: everywhere.
            let [columns, rows] = self.size.map(|n| [0, n - 1]);
            return Some(Outline { columns, rows, depth: 0.0 });
        }
        let (by_near, by_far) = (1.0 / near, 1.0 / far);
        let span = |middle: f32, reach: f32, focal: f32, center: f32, n: u32| {
            let (low, high) = (middle - reach, middle + reach);
            let low = low * if low < 0.0 { by_near } else { by_far };
            let high = high * if high > 0.0 { by_near } else { by_far };
            let [low, high] = [low, high].map(|v| v * focal + center);
            let [low, high] = if focal < 0.0 { [high, low] } else { [low, high] };
            // Centres of pixels lie half a pixel in; a little more for their rounding.
            let [first, last] = [low - 0.6, high - 0.4];
            let is_seen = last >= 0.0 && first < n as f32;
            is_seen.then(|| [first.max(0.0) as u32, (last as u32).min(n - 1)])
        };
        let [fx, fy] = self.focal;
        Some(Outline {
            columns: span(middle.x, reach.x, fx, self.center[0], self.size[0])?,
            rows: span(middle.y, reach.y, -fy, self.center[1], self.size[1])?,
            depth: near,
        })
    }
}

#[cfg(test)]
mod tests;
