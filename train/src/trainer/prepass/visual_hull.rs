//! Where nothing can be, by the silhouettes: the visual hull of images with
//! alpha (Laurentini 1994), kept conservative so that thin parts survive.

use pocketnerf_core::{Camera, Space};
use rayon::prelude::*;

use crate::lens::{Lens, Rectangle};
use crate::trainer::pixels::rays::RaySource;

/// Largest alpha of ever larger squares of an image.
#[derive(Debug)]
struct Pyramid {
    /// Level 0 is the image itself: width, height, largest alpha.
    levels: Vec<(usize, usize, Vec<u8>)>,
}

impl Pyramid {
    /// What a pixel that does not count shows is not known: it carves nothing.
    fn new(width: usize, height: usize, rgba: &[u8], mask: Option<&[u8]>) -> Self {
        let mut alpha: Vec<u8> = rgba.iter().skip(3).step_by(4).copied().collect();
        for (alpha, _) in alpha.iter_mut().zip(mask.unwrap_or(&[])).filter(|(_, m)| **m == 0) {
            *alpha = 255;
        }
        let mut levels = vec![(width, height, alpha)];
        while let Some((w, h, below)) = levels.last().filter(|(w, h, _)| w.max(h) > &1) {
            let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
            let mut above = vec![0u8; half_w * half_h];
            for y in 0..*h {
                for x in 0..*w {
                    let to = &mut above[(y / 2) * half_w + x / 2];
                    *to = (*to).max(below[y * w + x]);
                }
            }
            levels.push((half_w, half_h, above));
        }
        Self { levels }
    }

    /// Whether any pixel of a rectangle (inclusive, inside the image) has
    /// alpha. May say yes a little too often.
    fn any(&self, [x0, y0, x1, y1]: [usize; 4]) -> bool {
        let size = (x1 - x0).max(y1 - y0) + 1;
        // Squares of a quarter of the rectangle: few of them, little beside it.
        let level = size.next_power_of_two().trailing_zeros().saturating_sub(2) as usize;
        let level = level.min(self.levels.len() - 1);
        let (w, _, alpha) = &self.levels[level];
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|c| c >> level);
        let mut rows = alpha[y0 * w..].chunks(*w).take(y1 - y0 + 1);
        rows.any(|row| row[x0..=x1].iter().any(|alpha| *alpha > 0))
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
        let mut seen = 0;
        for (camera, lens, pyramid) in &self.views {
            let footprint = match lens {
                Lens::Pinhole => footprint(camera, center, radius),
                lens => footprint_through(lens, camera, center, radius),
            };
            match footprint {
                Footprint::Inside(rectangle) if !pyramid.any(rectangle) => return false,
                Footprint::Inside(_) | Footprint::Cut => seen += 1,
                Footprint::Unseen => {}
            }
        }
        4 * seen >= self.views.len()
    }

    /// Cells that may hold something of a grid of `resolution`³ cells (a power
    /// of two from 16 up) over the cube of the space, in ascending order of
    /// `x + n (y + n z)`, for a space that is a box. Cells outside it are left out.
    #[must_use]
    pub fn cells(&self, space: &Space, resolution: u32) -> Vec<u32> {
        let map = space.unit_map();
        let mut size = 16;
        let mut cells: Vec<[u32; 3]> = (0..size * size * size)
            .map(|i| [i % size, i / size % size, i / (size * size)])
            .collect();
        loop {
            let side = 1.0 / (size as f32 * map.scale);
            let radius = side * 0.5 * 3f32.sqrt();
            let [_, max] = space.bounds();
            cells.retain(|cell| (0..3).all(|a| map.min[a] + cell[a] as f32 * side < max[a]));
            cells = cells
                .into_par_iter()
                .filter(|cell| {
                    let center = [0, 1, 2].map(|a| map.min[a] + (cell[a] as f32 + 0.5) * side);
                    self.may_hold(center, radius)
                })
                .collect();
            if size >= resolution {
                break;
            }
            size *= 2;
            cells = cells
                .iter()
                .flat_map(|c| (0..8).map(|i| [0, 1, 2].map(|a| c[a] * 2 + (i >> a & 1))))
                .collect();
        }
        let mut numbers: Vec<u32> =
            cells.iter().map(|c| c[0] + size * (c[1] + size * c[2])).collect();
        numbers.sort_unstable();
        numbers
    }
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
