//! Which pixels can see anything at all.
//!
//! A pixel whose ray meets no cell that may hold something teaches nothing: its
//! gradient is zero whatever the field. Training draws its rays from the tiles
//! of the images that such cells project to.

use pocketnerf_core::{Camera, Space};
use rayon::prelude::*;

use crate::lens::{Lens, Rectangle};
use crate::random::Random;
use crate::trainer::pixels::rays::{Pixel, RaySource};

/// Pixels along a tile's side.
const TILE: u32 = 8;
/// Cells along a side of the cubes that are projected.
const CUBE: u32 = 4;

/// A tile of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Tile {
    view: u32,
    y: u16,
    x: u16,
}

/// The tiles that see something.
#[derive(Clone, Debug)]
pub(crate) struct PixelVisibility {
    /// Ascending.
    tiles: Vec<Tile>,
    /// Which pixels of each tile count, a bit each, row after row of eight. Empty where
    /// all do.
    counting: Vec<u64>,
    /// Share of all pixels that count that lie in the tiles.
    share: f64,
}

impl PixelVisibility {
    /// The tiles of all views to which `cells` of a grid of so many cells along
    /// an axis project. Where there are none, all tiles. Tiles in which no pixel counts
    /// are left out.
    pub(crate) fn new(source: &RaySource, space: &Space, resolution: u32, cells: &[u32]) -> Self {
        let (cameras, lenses) = (source.cameras(), source.lenses());
        let cubes = Cubes::new(space, resolution, cells);
        let per_view = cameras.par_iter().zip(lenses).enumerate().map(|(view, (camera, lens))| {
            let mut seen = Seen::new(camera);
            match lens {
                Lens::Pinhole => {
                    cubes.corners.iter().for_each(|cube| seen.mark(camera, cube, cubes.side));
                }
                lens => {
                    cubes.corners.iter().for_each(|cube| {
                        seen.mark_ball_around((camera, lens), cube, cubes.side);
                    });
                }
            }
            seen.tiles(view as u32)
        });
        let counts = |tile: &Tile| counting(source, tile) != 0;
        let mut tiles: Vec<Tile> = per_view.flatten_iter().filter(counts).collect();
        if tiles.is_empty() {
            let all = |(view, camera): (usize, &Camera)| {
                let mut seen = Seen::new(camera);
                seen.marks.fill(true);
                seen.tiles(view as u32)
            };
            tiles = cameras.iter().enumerate().flat_map(all).filter(counts).collect();
        }
        let pixels = |tile: &Tile| u64::from(counting(source, tile).count_ones());
        let seen: u64 = tiles.par_iter().map(pixels).sum();
        let of_view = |(view, camera): (usize, &Camera)| {
            let pixels = camera.width as usize * camera.height as usize;
            match source.all_count(view) {
                true => pixels,
                false => (0..pixels).filter(|i| source.counts(view, *i)).count(),
            }
        };
        let all = cameras.iter().enumerate().map(of_view).sum::<usize>() as u64;
        let is_masked = (0..cameras.len()).any(|view| !source.all_count(view));
        let counting = match is_masked {
            true => tiles.par_iter().map(|tile| counting(source, tile)).collect(),
            false => Vec::new(),
        };
        Self { tiles, counting, share: seen as f64 / all.max(1) as f64 }
    }

    /// Share of all pixels that may be drawn.
    pub(crate) fn share(&self) -> f64 {
        self.share
    }

    /// Whether a pixel may be drawn.
    pub(crate) fn draws(&self, pixel: Pixel) -> bool {
        let Pixel { view, x, y } = pixel;
        let tile = Tile { view, y: (y / TILE) as u16, x: (x / TILE) as u16 };
        let counts = |i: usize| {
            let bits = self.counting.get(i).copied().unwrap_or(u64::MAX);
            bits >> (y % TILE * TILE + x % TILE) & 1 == 1
        };
        self.tiles.binary_search(&tile).is_ok_and(counts)
    }

    /// How many tiles there are.
    pub(crate) fn n_tiles(&self) -> usize {
        self.tiles.len()
    }

    /// The view that a tile is of.
    pub(crate) fn view(&self, tile: usize) -> usize {
        self.tiles[tile].view as usize
    }

    /// A random pixel of a tile, one that counts.
    #[inline]
    pub(crate) fn pixel(&self, cameras: &[Camera], tile: usize, random: &mut Random) -> Pixel {
        let counting = self.counting.get(tile).copied();
        let tile = self.tiles[tile];
        if let Some(mut bits) = counting {
            // As with the edges, masked tiles are drawn a little too often.
            for _ in 0..random.below(bits.count_ones() as usize) {
                bits &= bits - 1;
            }
            let (x, y) = (bits.trailing_zeros() % TILE, bits.trailing_zeros() / TILE);
            let (x, y) = (u32::from(tile.x) * TILE + x, u32::from(tile.y) * TILE + y);
            return Pixel { view: tile.view, x, y };
        }
        // Tiles on an edge may be smaller; one in a hundred is drawn a little
        // too often, which does not matter.
        let [width, height] = size(&cameras[tile.view as usize], &tile);
        let inside = random.below((width * height) as usize) as u32;
        let (x, y) = (inside % width, inside / width);
        Pixel { view: tile.view, x: u32::from(tile.x) * TILE + x, y: u32::from(tile.y) * TILE + y }
    }
}

/// Pixels along both sides of a tile.
fn size(camera: &Camera, tile: &Tile) -> [u32; 2] {
    let side = |first: u16, pixels: u32| TILE.min(pixels - u32::from(first) * TILE);
    [side(tile.x, camera.width), side(tile.y, camera.height)]
}

/// Which pixels of a tile count, a bit each.
fn counting(source: &RaySource, tile: &Tile) -> u64 {
    let camera = &source.cameras()[tile.view as usize];
    let [width, height] = size(camera, tile);
    let (left, top) = (u32::from(tile.x) * TILE, u32::from(tile.y) * TILE);
    let mut bits = 0;
    if source.all_count(tile.view as usize) {
        let row = (1 << width) - 1;
        return (0..height).fold(0, |bits, y| bits | row << (y * TILE));
    }
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let i = (top + y) as usize * camera.width as usize + (left + x) as usize;
        bits |= u64::from(source.counts(tile.view as usize, i)) << (y * TILE + x);
    }
    bits
}

/// Cubes of cells in scene space.
struct Cubes {
    /// Smallest corner of each, scene units.
    corners: Vec<[f32; 3]>,
    /// Side, scene units.
    side: f32,
}

impl Cubes {
    fn new(space: &Space, resolution: u32, cells: &[u32]) -> Self {
        let n = resolution.div_ceil(CUBE);
        let mut marks = vec![false; (n * n * n) as usize];
        for cell in cells {
            let [x, y, z] =
                [cell % resolution, cell / resolution % resolution, cell / resolution.pow(2)];
            marks[(x / CUBE + n * (y / CUBE + n * (z / CUBE))) as usize] = true;
        }
        let map = space.unit_map();
        let side = CUBE as f32 / (resolution as f32 * map.scale);
        let marked = (0..n * n * n).filter(|cube| marks[*cube as usize]);
        let corners = marked.map(|cube| {
            let at = [cube % n, cube / n % n, cube / (n * n)];
            [0, 1, 2].map(|a| map.min[a] + at[a] as f32 * side)
        });
        Self { corners: corners.collect(), side }
    }
}

/// The tiles of one view.
struct Seen {
    columns: u32,
    rows: u32,
    marks: Vec<bool>,
}

impl Seen {
    fn new(camera: &Camera) -> Self {
        let (columns, rows) = (camera.width.div_ceil(TILE), camera.height.div_ceil(TILE));
        Self { columns, rows, marks: vec![false; (columns * rows) as usize] }
    }

    /// Marks the tiles that the rectangle around a projected cube touches.
    fn mark(&mut self, camera: &Camera, corner: &[f32; 3], side: f32) {
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let mut behind = 0;
        for c in 0..8u8 {
            let p = [0, 1, 2].map(|a| corner[a] + f32::from(c >> a & 1) * side);
            let Some(at) = camera.project(p) else {
                behind += 1;
                continue;
            };
            for axis in 0..2 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        if behind > 0 {
            // A cube that the camera's plane cuts may be seen anywhere.
            if behind < 8 {
                self.marks.fill(true);
            }
            return;
        }
        self.mark_between(low, high);
    }

    /// The same through a lens: the tiles that may show the ball around a cube.
    fn mark_ball_around(&mut self, (camera, lens): (&Camera, &Lens), corner: &[f32; 3], side: f32) {
        let center = corner.map(|low| low + 0.5 * side);
        match lens.rectangle(camera, center, 0.5 * side * 3f32.sqrt()) {
            Rectangle::Within([x0, y0, x1, y1]) => self.mark_between([x0, y0], [x1, y1]),
            Rectangle::Unknown => self.marks.fill(true),
            Rectangle::Nothing => {}
        }
    }

    /// Marks the tiles between two image points.
    fn mark_between(&mut self, low: [f32; 2], high: [f32; 2]) {
        // `as` saturates: what lies outside is cut off.
        let first = low.map(|v| (v / TILE as f32) as u32);
        let end = high.map(|v| if v < 0.0 { 0 } else { (v / TILE as f32) as u32 + 1 });
        for y in first[1]..end[1].min(self.rows) {
            let row = (y * self.columns) as usize;
            let columns = first[0] as usize..end[0].min(self.columns) as usize;
            if columns.start < columns.end {
                self.marks[row + columns.start..row + columns.end].fill(true);
            }
        }
    }

    fn tiles(&self, view: u32) -> Vec<Tile> {
        let marked = (0..self.columns * self.rows).filter(|i| self.marks[*i as usize]);
        let tile =
            |i: u32| Tile { view, x: (i % self.columns) as u16, y: (i / self.columns) as u16 };
        marked.map(tile).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::View;
    use crate::trainer::pixels::rays::Backdrop;

    fn source(cameras: &[Camera], lens: Lens, mask: Option<&[u8]>) -> RaySource {
        let view = |camera: &Camera| {
            let rgba = vec![255; 4 * (camera.width * camera.height) as usize];
            View { lens, mask: mask.map(<[u8]>::to_vec), ..View::new("", *camera, rgba) }
        };
        RaySource::new(cameras.iter().map(view).collect(), Backdrop::Random)
    }

    /// Of pictures of 61x47 pixels.
    fn pixels() -> impl Iterator<Item = (u32, u32)> {
        (0..47).flat_map(|y| (0..61).map(move |x| (x, y)))
    }

    #[test]
    fn masked_pixels_are_never_drawn() {
        // The left half, and every seventh pixel, are ignored.
        let counts = |x: u32, y: u32| x >= 30 && !(x + 61 * y).is_multiple_of(7);
        let mask: Vec<u8> = pixels().map(|(x, y)| u8::from(counts(x, y))).collect();
        let pose = Camera::look_at([3.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = Camera::from_fov_x(61, 47, 1.0, pose);
        let source = source(&[camera], Lens::Pinhole, Some(&mask));
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let visibility = PixelVisibility::new(&source, &space, 32, &[]);
        assert!((visibility.share() - 1.0).abs() < 1e-12);
        let mut random = Random::new(1, [0; 3]);
        let mut drawn = vec![0; mask.len()];
        for _ in 0..40_000 {
            let tile = random.below(visibility.n_tiles());
            let Pixel { x, y, .. } = visibility.pixel(source.cameras(), tile, &mut random);
            drawn[(x + 61 * y) as usize] += 1;
        }
        for ((x, y), (times, counts)) in pixels().zip(drawn.iter().zip(&mask)) {
            // About 32 each.
            assert_eq!(*times > 0, *counts != 0, "{x} {y}");
            assert_eq!(visibility.draws(Pixel { view: 0, x, y }), *counts != 0, "{x} {y}");
        }
    }

    #[test]
    fn every_ray_that_meets_a_cell_can_be_drawn() {
        for lens in [
            Lens::Pinhole,
            Lens::open_cv([-0.2, 0.1, 0.0, 0.0], [0.01, 0.0]),
            Lens::fisheye([0.05, 0.0, 0.0, 0.0]),
        ] {
            rays_can_be_drawn(lens);
        }
    }

    fn rays_can_be_drawn(lens: Lens) {
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let map = space.unit_map();
        let cells = [5 + 32 * (6 + 32 * 7), 20 + 32 * (25 + 32 * 3)];
        let eyes = [[3.0, 0.5, 0.2], [-0.3, 2.5, 1.0], [0.1, 0.2, 0.3]];
        let cameras = eyes.map(|eye| {
            let pose = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]);
            Camera::from_fov_x(61, 47, 1.0, pose)
        });
        let source = source(&cameras, lens, None);
        let visibility = PixelVisibility::new(&source, &space, 32, &cells);
        let drawn = |view: u32, x, y| visibility.draws(Pixel { view, x, y });
        let (mut met, mut missed) = (0, 0);
        for (view, (x, y)) in (0..3).flat_map(|view| pixels().map(move |pixel| (view, pixel))) {
            let ray = source.through(Pixel { view, x, y });
            let meets = (0..4000).any(|k| {
                let t = k as f32 * 1e-3;
                let p = [0, 1, 2].map(|a| ray.origin[a] + t * ray.direction[a]);
                let cell = map.apply(p).map(|u| (u * 32.0).floor() as i32);
                cells.iter().any(|c| [c % 32, c / 32 % 32, c / 1024].map(|v| v as i32) == cell)
            });
            assert!(!meets || drawn(view, x, y), "view {view}: pixel {x}, {y}");
            met += u32::from(meets);
            missed += u32::from(!drawn(view, x, y));
        }
        assert!(met > 5 && missed > 1000, "{lens:?}: {met} {missed}");
        let mut random = Random::new(1, [0; 3]);
        for _ in 0..1000 {
            let tile = random.below(visibility.n_tiles());
            let Pixel { view, x, y } = visibility.pixel(&cameras, tile, &mut random);
            assert!(x < 61 && y < 47 && drawn(view, x, y));
        }
        // Nothing to see: everything may be drawn.
        assert!((PixelVisibility::new(&source, &space, 32, &[]).share() - 1.0).abs() < 1e-12);
    }
}
