//! Where nothing can be, by the silhouettes: the visual hull of images with
//! alpha (Laurentini 1994), kept conservative so that thin parts survive.

mod pyramid;
#[cfg(test)]
mod tests;

use pocketnerf_core::{Camera, Space};
use rayon::prelude::*;

use super::Deadline;
use crate::lens::{Lens, Rectangle};
use crate::trainer::pixels::rays::RaySource;
use pyramid::Pyramid;

/// One view in so many may be wrong: a photograph that is upside down, or whose pose is that of
/// another one, must not carve the scene away.
const WRONG: usize = 50;
/// Of so many views one may be.
const ENOUGH: usize = 10;

/// Pixels around what a ball covers: alpha is an average over the pixel's square.
const MARGIN: f32 = 1.0;
/// What rounding may move a corner by, in pixels.
const ROUNDING: f32 = 0.01;

/// Silhouettes of all training views.
#[derive(Debug)]
pub struct VisualHull {
    /// After this, no more cells are looked for.
    deadline: Deadline,
    /// So many views may see a part of the scene as transparent.
    wrong: usize,
    views: Vec<(Camera, Lens, Pyramid)>,
}

impl VisualHull {
    /// From the views' cameras and RGBA images.
    #[must_use]
    pub fn new(source: &RaySource) -> Self {
        Self::before(source, Deadline::NONE)
    }

    /// The same; where the deadline passes, it finds no more cells.
    pub(super) fn before(source: &RaySource, deadline: Deadline) -> Self {
        let cameras = source.cameras().par_iter().zip(source.lenses());
        let images = source.images().par_iter().zip(source.masks());
        let view = |((camera, lens), (rgba, mask)): ((&Camera, &Lens), (&Vec<u8>, &_))| {
            let mask: &Option<Vec<u8>> = mask;
            let (width, height) = (camera.width as usize, camera.height as usize);
            (*camera, *lens, Pyramid::new(width, height, rgba, mask.as_deref()))
        };
        let n = source.cameras().len();
        let wrong = match source.is_cut_out() {
            // White parts on white look like the background, from many sides.
            true => n / 2,
            false => (n / WRONG).max(usize::from(n >= ENOUGH)),
        };
        Self { deadline, wrong, views: cameras.zip(images).map(view).collect() }
    }

    /// Whether a ball around `center` (scene units) may hold something: false
    /// if some views, more than one in fifty (before a plain background, one in two), see all of
    /// it against a transparent background, or if fewer than a quarter of the views see its
    /// centre: what so few silhouettes confine is mostly the space beside the object.
    #[must_use]
    pub fn may_hold(&self, center: [f32; 3], radius: f32) -> bool {
        self.look(0..self.views.len(), center, radius, |_, _| ())
    }

    /// The same by these views alone; all the others see every part of the ball in front of
    /// something. Tells `then` what each view sees of a ball that may hold something.
    fn look(
        &self,
        views: impl ExactSizeIterator<Item = usize>,
        center: [f32; 3],
        radius: f32,
        mut then: impl FnMut(usize, &Footprint),
    ) -> bool {
        let mut seen = self.views.len() - views.len();
        let (all, mut transparent) = (self.views.len(), 0);
        for view in views {
            let (camera, lens, pyramid) = &self.views[view];
            let footprint = match lens {
                Lens::Pinhole => footprint(camera, center, radius),
                lens => footprint_through(lens, camera, center, radius),
            };
            match footprint {
                Footprint::Inside(corners) if !pyramid.any(pixels(corners)) => {
                    transparent += 1;
                    if transparent > self.wrong {
                        return false;
                    }
                    seen += 1;
                }
                Footprint::Inside(_) | Footprint::Cut => seen += 1,
                Footprint::Unseen => {}
            }
            then(view, &footprint);
        }
        4 * seen >= all
    }

    /// Cells that may hold something of a grid of `resolution`³ cells (a power
    /// of two from 16 up) over the cube of the space, in ascending order of
    /// `x + n (y + n z)`, for a space that is a box. Cells outside it are left out.
    #[must_use]
    pub fn cells(&self, space: &Space, resolution: u32) -> Vec<u32> {
        let all: Vec<usize> = (0..self.views.len()).collect();
        let grid = Grid { space, resolution };
        let mut cells: Vec<u32> = (0..16u32.pow(3))
            .into_par_iter()
            .flat_map_iter(|i| {
                let mut cells = Vec::new();
                if self.deadline.has_passed() {
                    return cells;
                }
                self.descend(&grid, [i % 16, i / 16 % 16, i / 256], 16, &all, &mut cells);
                cells
            })
            .collect();
        cells.par_sort_unstable();
        cells
    }

    /// Adds the finest cells of a cell of a grid of `size`³. Only the views `open` may see a
    /// part of it against a transparent background.
    fn descend(
        &self,
        grid: &Grid<'_>,
        cell: [u32; 3],
        size: u32,
        open: &[usize],
        cells: &mut Vec<u32>,
    ) {
        let map = grid.space.unit_map();
        let side = 1.0 / (size as f32 * map.scale);
        let radius = side * 0.5 * 3f32.sqrt();
        let [_, max] = grid.space.bounds();
        if (0..3).any(|a| map.min[a] + cell[a] as f32 * side >= max[a]) {
            return;
        }
        let center = [0, 1, 2].map(|a| map.min[a] + (cell[a] as f32 + 0.5) * side);
        let views = open.iter().copied();
        if size >= grid.resolution {
            if self.look(views, center, radius, |_, _| ()) {
                cells.push(cell[0] + size * (cell[1] + size * cell[2]));
            }
            return;
        }
        // The balls of the parts lie within this one.
        let mut open = Vec::with_capacity(open.len());
        let may_hold = self.look(views, center, radius, |view, footprint| {
            if !footprint.shows_every_part(&self.views[view].2) {
                open.push(view);
            }
        });
        if may_hold {
            for i in 0..8 {
                let part = [0, 1, 2].map(|a| cell[a] * 2 + (i >> a & 1));
                self.descend(grid, part, size * 2, &open, cells);
            }
        }
    }
}

/// Cells over the cube of a space.
struct Grid<'a> {
    space: &'a Space,
    resolution: u32,
}

/// What a camera sees of a ball.
enum Footprint {
    /// All of it, between `[x0, y0, x1, y1]` in pixels; there is [`MARGIN`] on every side.
    Inside([f32; 4]),
    /// Its centre, or it is too near to tell.
    Cut,
    /// Not its centre.
    Unseen,
}

impl Footprint {
    /// Whether the footprint of every ball within this one has a pixel with alpha.
    fn shows_every_part(&self, pyramid: &Pyramid) -> bool {
        let Self::Inside(corners) = *self else { return false };
        let [x0, y0, x1, y1] = corners;
        // Wherever the centre of a part is, its margin reaches these.
        let within = 2.0 * MARGIN - ROUNDING;
        let shared = [x1 - within, y1 - within, x0 + within, y0 + within];
        let is_shared = shared[0] <= shared[2] && shared[1] <= shared[3];
        (is_shared && pyramid.any(pixels(shared))) || pyramid.all(pixels(corners))
    }
}

/// The pixels between two corners.
fn pixels(corners: [f32; 4]) -> [usize; 4] {
    corners.map(|v| v as usize)
}

fn footprint(camera: &Camera, center: [f32; 3], radius: f32) -> Footprint {
    let m = &camera.camera_to_world;
    let d = [center[0] - m[3], center[1] - m[7], center[2] - m[11]];
    let along = |c: usize| d[0] * m[c] + d[1] * m[4 + c] + d[2] * m[8 + c];
    let depth = -along(2);
    if depth <= 2.0 * radius {
        return if depth > -radius { Footprint::Cut } else { Footprint::Unseen };
    }
    let x = camera.center[0] + camera.focal[0] * along(0) / depth;
    let y = camera.center[1] - camera.focal[1] * along(1) / depth;
    // A ball off the axis covers more than f r / depth: by 1 / cos² at most.
    let off_axis = (along(0) * along(0) + along(1) * along(1)) / (depth * depth);
    let spread = radius / (depth - radius) * (1.0 + off_axis);
    let (rx, ry) = (camera.focal[0] * spread + MARGIN, camera.focal[1] * spread + MARGIN);
    within(camera, [x - rx, y - ry, x + rx, y + ry])
}

/// The same through a lens.
fn footprint_through(lens: &Lens, camera: &Camera, center: [f32; 3], radius: f32) -> Footprint {
    match lens.rectangle(camera, center, radius) {
        Rectangle::Within([x0, y0, x1, y1]) => {
            within(camera, [x0 - MARGIN, y0 - MARGIN, x1 + MARGIN, y1 + MARGIN])
        }
        Rectangle::Unknown => Footprint::Cut,
        Rectangle::Nothing => Footprint::Unseen,
    }
}

/// A rectangle of pixels.
fn within(camera: &Camera, corners: [f32; 4]) -> Footprint {
    let [x0, y0, x1, y1] = corners;
    let (width, height) = (camera.width as f32, camera.height as f32);
    if x0 >= 0.0 && y0 >= 0.0 && x1 < width && y1 < height {
        Footprint::Inside(corners)
    } else if x1 >= 0.0 && y1 >= 0.0 && x0 < width && y0 < height {
        Footprint::Cut
    } else {
        Footprint::Unseen
    }
}
