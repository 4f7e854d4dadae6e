//! Where nothing can be, by the silhouettes: the visual hull of images with
//! alpha (Laurentini 1994), kept conservative so that thin parts survive.

use pocketnerf_core::{Camera, Space};
use rayon::prelude::*;

use crate::lens::{Lens, Rectangle};
use crate::trainer::pixels::rays::RaySource;

/// Of a square of pixels: one of them has alpha.
const SOME: u8 = 1;
/// All of them have.
const ALL: u8 = 2;

/// What ever larger squares of an image show.
#[derive(Debug)]
struct Pyramid {
    /// Level 0 is the image itself: width, height, [`SOME`] and [`ALL`] of each square.
    levels: Vec<(usize, usize, Vec<u8>)>,
}

impl Pyramid {
    /// What a pixel that does not count shows is not known: it carves nothing.
    fn new(width: usize, height: usize, rgba: &[u8], mask: Option<&[u8]>) -> Self {
        let shows = |alpha: u8| if alpha > 0 { SOME | ALL } else { 0 };
        let mut pixels: Vec<u8> = rgba.iter().skip(3).step_by(4).map(|a| shows(*a)).collect();
        for (pixel, _) in pixels.iter_mut().zip(mask.unwrap_or(&[])).filter(|(_, m)| **m == 0) {
            *pixel = SOME | ALL;
        }
        let mut levels = vec![(width, height, pixels)];
        while let Some((w, h, below)) = levels.last().filter(|(w, h, _)| w.max(h) > &1) {
            let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
            let mut above = vec![ALL; half_w * half_h];
            for y in 0..*h {
                for x in 0..*w {
                    let (to, from) = (&mut above[(y / 2) * half_w + x / 2], below[y * w + x]);
                    *to = (*to | from & SOME) & (from | SOME);
                }
            }
            levels.push((half_w, half_h, above));
        }
        Self { levels }
    }

    /// Whether any pixel of a rectangle (inclusive, inside the image) has
    /// alpha. May say yes a little too often.
    fn any(&self, rectangle: [usize; 4]) -> bool {
        // Squares of a quarter of the rectangle: few of them, little beside it.
        self.rows(rectangle, 4).any(|row| row.iter().any(|square| square & SOME != 0))
    }

    /// Whether all of them have. May say no a little too often.
    fn all(&self, rectangle: [usize; 4]) -> bool {
        self.rows(rectangle, 2).all(|row| row.iter().all(|square| square & ALL != 0))
    }

    /// The squares that cover a rectangle, with about `across` of them along its longer side.
    fn rows(&self, [x0, y0, x1, y1]: [usize; 4], across: u32) -> impl Iterator<Item = &[u8]> {
        let size = (x1 - x0).max(y1 - y0) + 1;
        let level = size.next_power_of_two().trailing_zeros().saturating_sub(across.ilog2());
        let level = (level as usize).min(self.levels.len() - 1);
        let (w, _, squares) = &self.levels[level];
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|c| c >> level);
        squares[y0 * w..].chunks(*w).take(y1 - y0 + 1).map(move |row| &row[x0..=x1])
    }
}

/// Silhouettes of all training views.
#[derive(Debug)]
pub struct VisualHull {
    views: Vec<(Camera, Lens, Pyramid)>,
}

impl VisualHull {
    /// From the views' cameras and RGBA images.
    #[must_use]
    pub fn new(source: &RaySource) -> Self {
        let cameras = source.cameras().par_iter().zip(source.lenses());
        let images = source.images().par_iter().zip(source.masks());
        let view = |((camera, lens), (rgba, mask)): ((&Camera, &Lens), (&Vec<u8>, &_))| {
            let mask: &Option<Vec<u8>> = mask;
            let (width, height) = (camera.width as usize, camera.height as usize);
            (*camera, *lens, Pyramid::new(width, height, rgba, mask.as_deref()))
        };
        Self { views: cameras.zip(images).map(view).collect() }
    }

    /// Whether a ball around `center` (scene units) may hold something: false
    /// if some view sees all of it against a transparent background, or if
    /// fewer than a quarter of the views see its centre: what so few silhouettes
    /// confine is mostly the space beside the object.
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
        for view in views {
            let (camera, lens, pyramid) = &self.views[view];
            let footprint = match lens {
                Lens::Pinhole => footprint(camera, center, radius),
                lens => footprint_through(lens, camera, center, radius),
            };
            match footprint {
                Footprint::Inside(rectangle) if !pyramid.any(rectangle) => return false,
                Footprint::Inside(_) | Footprint::Cut => seen += 1,
                Footprint::Unseen => {}
            }
            then(view, &footprint);
        }
        4 * seen >= self.views.len()
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
        let may_hold = self.look(views, center, radius, |view, footprint| match footprint {
            Footprint::Inside(rectangle) if self.views[view].2.all(*rectangle) => {}
            _ => open.push(view),
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
    /// All of it, within the pixels `[x0, y0, x1, y1]`.
    Inside([usize; 4]),
    /// Its centre, or it is too near to tell.
    Cut,
    /// Not its centre.
    Unseen,
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
    // One pixel more: alpha is an average over the pixel's square.
    let (rx, ry) = (camera.focal[0] * spread + 1.0, camera.focal[1] * spread + 1.0);
    within(camera, [x - rx, y - ry, x + rx, y + ry])
}

/// The same through a lens.
fn footprint_through(lens: &Lens, camera: &Camera, center: [f32; 3], radius: f32) -> Footprint {
    match lens.rectangle(camera, center, radius) {
        Rectangle::Within([x0, y0, x1, y1]) => {
            within(camera, [x0 - 1.0, y0 - 1.0, x1 + 1.0, y1 + 1.0])
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
        Footprint::Inside(corners.map(|v| v as usize))
    } else if x1 >= 0.0 && y1 >= 0.0 && x0 < width && y0 < height {
        Footprint::Cut
    } else {
        Footprint::Unseen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::View;
    use crate::trainer::Backdrop;

    /// Cameras on the axes, which see a disc of `radius` pixels.
    fn views(radius: f32) -> RaySource {
        let eyes = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.1], [0.0, 0.0, 4.0]];
        let cameras: Vec<Camera> = eyes
            .iter()
            .map(|eye| {
                let up = if eye[2] > 1.0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
                Camera::from_fov_x(101, 101, 0.7, Camera::look_at(*eye, [0.0; 3], up))
            })
            .collect();
        let image: Vec<u8> = (0..101 * 101)
            .flat_map(|i| {
                let (x, y) = ((i % 101) as f32 - 50.0, (i / 101) as f32 - 50.0);
                [0, 0, 0, if x * x + y * y <= radius * radius { 255 } else { 0 }]
            })
            .collect();
        let views = cameras.into_iter().map(|camera| View::new("", camera, image.clone()));
        RaySource::new(views.collect(), Backdrop::Random)
    }

    #[test]
    fn keeps_what_the_silhouettes_allow() {
        let hull = VisualHull::new(&views(10.0));
        // Small enough for every view to see all of it.
        let space = Space::Box { min: [-0.9; 3], max: [0.9; 3] };
        let cells = hull.cells(&space, 64);
        // 10 pixels at distance 4 and focal 138 are 0.29 units: three
        // cylinders' intersection, at least the ball, grown by about a cell.
        let center =
            |n: u32| [n % 64, n / 64 % 64, n / 4096].map(|c| (c as f32 + 0.5) * 1.8 / 64.0 - 0.9);
        let norm = |p: [f32; 3]| p.iter().map(|v| v * v).sum::<f32>().sqrt();
        assert!(cells.iter().all(|n| norm(center(*n)) < 0.29 * 1.5 + 0.15));
        let ball = (0..64u32.pow(3)).filter(|n| norm(center(*n)) < 0.28);
        let mut inside = 0;
        for n in ball {
            assert!(cells.binary_search(&n).is_ok(), "a cell of the ball was carved away");
            inside += 1;
        }
        assert!(inside > 500 && cells.len() < 6 * inside, "{inside} {}", cells.len());
    }

    #[test]
    fn masked_pixels_carve_nothing() {
        let views = views(0.5);
        let masked = |mask: Vec<u8>| {
            let view = |i: usize| View {
                mask: Some(mask.clone()),
                ..View::new("", views.cameras()[i], views.images()[i].clone())
            };
            VisualHull::new(&RaySource::new((0..3).map(view).collect(), Backdrop::Random))
        };
        let all = vec![1; 101 * 101];
        assert!(!masked(all.clone()).may_hold([0.3, 0.0, 0.0], 1e-3));
        // 0.3 units at distance 4 and focal 138 are ten pixels: the upper half decides, as
        // seen from the second and third camera, and nothing is known of the lower.
        assert!(masked(vec![0; 101 * 101]).may_hold([0.3, 0.0, 0.0], 1e-3));
        let mut upper = all;
        upper[101 * 45..].fill(0);
        assert!(masked(upper).may_hold([0.3, 0.0, 0.0], 1e-3));
    }

    /// A lens that bends shows the disc elsewhere; what it shows is kept, and what lies
    /// where a pinhole would see it is not.
    #[test]
    fn silhouettes_through_a_lens() {
        let pinhole = views(0.5);
        let lens = Lens::open_cv([4.0, 0.0, 0.0, 0.0], [0.0; 2]);
        let source = |lens: Lens| {
            let view = |(camera, center): (&Camera, [f32; 2])| {
                let image: Vec<u8> = (0..101 * 101)
                    .flat_map(|i| {
                        let (x, y) = ((i % 101) as f32 + 0.5, (i / 101) as f32 + 0.5);
                        let near = (x - center[0]).hypot(y - center[1]) <= 2.0;
                        [0, 0, 0, if near { 255 } else { 0 }]
                    })
                    .collect();
                View { lens, ..View::new("", *camera, image) }
            };
            let views = pinhole.cameras().iter().map(|camera| {
                // Where the lens shows (0.6, 0.6, 0.6).
                view((camera, lens.project(camera, [0.6; 3]).unwrap()))
            });
            VisualHull::new(&RaySource::new(views.collect(), Backdrop::Random))
        };
        assert!(source(lens).may_hold([0.6; 3], 1e-3));
        assert!(!source(lens).may_hold([0.5; 3], 1e-3));
        let straight = pinhole.cameras()[0].project([0.6; 3]).unwrap();
        let bent = lens.project(&pinhole.cameras()[0], [0.6; 3]).unwrap();
        assert!((straight[0] - bent[0]).abs() > 2.0, "{straight:?} {bent:?}");
    }

    #[test]
    fn one_pixel_is_never_lost() {
        let hull = VisualHull::new(&views(0.5));
        assert!(hull.may_hold([0.0; 3], 1e-3));
        assert!(!hull.may_hold([0.3, 0.0, 0.0], 1e-3));
    }
}
