//! Where the surfaces face that a camera sees.
//!
//! Photographs tell how far light comes from; what density does within a wall they do not tell, and
//! its gradient there is noise. So planes are fitted to depths: a plane that the camera sees at z
//! along its axis has `1 / z = a x + b y + c` in image coordinates, for which weighted least squares
//! have one solution.

use glam::{DMat3, DVec3, Vec3};
use pocketnerf_core::query::Depth;
use pocketnerf_core::{Camera, Error, Model, Ray};
use rayon::prelude::*;

use super::{Antialias, Settings, depths, ray, render};

/// A surface is where this part of the light has been held back. Where a picture has fog before
/// its walls, less of it would be the fog.
const HALF: f32 = 0.5;
/// A plane is fitted to what is seen within so many occupied cells, and at least a pixel.
const CELLS: f32 = 4.0;
/// Occupied cells along the longest side of a model without such.
const USUAL: f32 = 128.0;
/// At most so many pixels on each side of the one in the middle count.
const SIDE: usize = 3;
const TAPS: usize = (2 * SIDE + 1) * (2 * SIDE + 1);
/// Another surface begins where depth changes by so many times the distance between the pixels.
const STEEP: f64 = 3.0;
/// Where a pixel lies off the plane by this part of the radius, it counts half.
const OFF: f64 = 0.2;
/// Fits, each with the weights that follow from the one before.
const FITS: usize = 4;

/// The normals of what `camera` sees through the centres of its pixels, one each to `out`, row
/// after row: unit vectors towards the camera, the model's axes; zeros where more than half of the
/// light passes. How many rays a pixel has and which of them are interpolated changes nothing.
///
/// A normal is that of the plane through what is seen around a pixel, within four of the model's
/// occupied cells and at least one pixel. What lies off that plane counts less, by the Cauchy
/// weight, so that edges stay (iteratively reweighted least squares, Holland and Welsch 1977).
///
/// # Errors
/// Whatever [`render_tile`](pocketnerf_core::render_tile) and [`Probe`](pocketnerf_core::Probe) report, and
/// [`Error::OutputLength`].
pub fn normals(
    model: &Model<'_>,
    camera: &Camera,
    settings: &Settings,
    out: &mut [[f32; 3]],
) -> Result<(), Error> {
    let (needed, given) = (camera.width as usize * camera.height as usize, out.len());
    if needed != given {
        return Err(Error::OutputLength { needed, given });
    }
    let seen = Seen::by(camera, model, settings)?;
    out.par_iter_mut().enumerate().for_each(|(pixel, normal)| *normal = seen.normal(pixel));
    Ok(())
}

/// What a camera sees.
struct Seen<'m> {
    model: &'m Model<'m>,
    camera: &'m Camera,
    /// Along the camera's axis, one a pixel; infinite where there is no surface.
    depth: Vec<f32>,
}

/// A pixel of those that a plane is fitted to.
#[derive(Clone, Copy, Default)]
struct Tap {
    /// From the one in the middle, in radii.
    at: [f64; 2],
    depth: f64,
    /// By its distance.
    weight: f64,
}

impl<'m> Seen<'m> {
    fn by(camera: &'m Camera, model: &'m Model<'m>, settings: &Settings) -> Result<Self, Error> {
        let mut depth = match model.space.scene_box() {
            Some(_) => depths(model, camera, Depth::Median, settings.simd)?,
            None => means(camera, model, settings)?,
        };
        let axis = Vec3::from(camera.axis());
        depth.par_iter_mut().enumerate().for_each(|(pixel, depth)| {
            *depth *= axis.dot(Vec3::from(ray(camera, pixel).direction));
        });
        Ok(Self { model, camera, depth })
    }

    fn normal(&self, pixel: usize) -> [f32; 3] {
        if !self.depth[pixel].is_finite() {
            return [0.0; 3];
        }
        let way = Vec3::from(ray(self.camera, pixel).direction);
        let plane = self.plane(pixel).filter(|normal| normal.dot(way) < 0.0);
        // Alone, nothing is known of it but that it is seen.
        plane.unwrap_or(-way).to_array()
    }

    /// The normal of the plane around a pixel; `None` where too little is seen of one.
    fn plane(&self, pixel: usize) -> Option<Vec3> {
        let radius = self.radius(pixel);
        let mut taps = [Tap::default(); TAPS];
        let n = self.taps(pixel, radius, &mut taps);
        let off = OFF * radius as f64 / f64::from(self.camera.focal[0]);
        let mut plane = None;
        for _ in 0..FITS {
            plane = Some(fit(&taps[..n], off, plane)?);
        }
        let [a, b, c] = plane?.to_array();
        // 1 / z = a (x - x0) / radius + b (y - y0) / radius + c is n · (x, y, 1) of the camera.
        let Camera { focal, center, camera_to_world: m, .. } = self.camera;
        let (x, y) = (pixel % self.width(), pixel / self.width());
        let [x, y] = [x as f64 + 0.5 - f64::from(center[0]), y as f64 + 0.5 - f64::from(center[1])];
        let [a, b] = [a, b].map(|slope| slope / radius as f64);
        let own = [a * f64::from(focal[0]), -b * f64::from(focal[1]), a * x + b * y - c];
        let row = |row: &[f32]| (0..3).map(|k| f64::from(row[k]) * own[k]).sum::<f64>();
        let away = DVec3::new(row(&m[..3]), row(&m[4..7]), row(&m[8..11]));
        (-away).try_normalize().map(DVec3::as_vec3)
    }

    /// Pixels around one that lie on the same surface, and how many these are.
    fn taps(&self, pixel: usize, radius: usize, taps: &mut [Tap; TAPS]) -> usize {
        let (width, height) = (self.width() as isize, self.camera.height as isize);
        let (x, y) = (pixel as isize % width, pixel as isize / width);
        let stride = radius.div_ceil(SIDE);
        let side = (radius / stride) as isize;
        let own = f64::from(self.depth[pixel]);
        let mut n = 0;
        for dy in (-side..=side).map(|k| k * stride as isize) {
            for dx in (-side..=side).map(|k| k * stride as isize) {
                let (tx, ty) = (x + dx, y + dy);
                if !((0..width).contains(&tx) && (0..height).contains(&ty)) {
                    continue;
                }
                let depth = f64::from(self.depth[(ty * width + tx) as usize]);
                let distance = ((dx * dx + dy * dy) as f64).sqrt();
                let farthest = STEEP * distance * own / f64::from(self.camera.focal[0]);
                let weight = 1.0 - (distance / (1.5 * radius as f64)).powi(2);
                if (depth - own).abs() <= farthest && weight > 0.0 {
                    let at = [dx, dy].map(|d| d as f64 / radius as f64);
                    taps[n] = Tap { at, depth, weight: weight * weight };
                    n += 1;
                }
            }
        }
        n
    }

    /// Within how many pixels a plane is fitted.
    fn radius(&self, pixel: usize) -> usize {
        let Model { space, occupancy, .. } = self.model;
        let cells = occupancy.map_or(USUAL, |occupancy| occupancy.resolution() as f32);
        let cell = 1.0 / (space.unit_map().scale * cells);
        // How large the pixel is there, local units.
        let Ray { origin, direction } = ray(self.camera, pixel);
        let (depth, m) = (self.depth[pixel], &self.camera.camera_to_world);
        let far = depth / Vec3::from(self.camera.axis()).dot(Vec3::from(direction));
        let at = Vec3::from(origin) + far * Vec3::from(direction);
        let beside = at + depth / self.camera.focal[0] * Vec3::new(m[0], m[4], m[8]);
        let local =
            |p: Vec3| space.local(&Ray { origin: p.to_array(), direction }).map(|r| r.origin);
        let size = local(at).zip(local(beside)).map(|(a, b)| Vec3::from(a).distance(Vec3::from(b)));
        let most = self.camera.width.min(self.camera.height) as usize / 8;
        // A cast takes NaN to 0.
        let radius = (CELLS * cell / size.unwrap_or(f32::INFINITY)).round() as usize;
        radius.min(most).max(1)
    }

    const fn width(&self) -> usize {
        self.camera.width as usize
    }
}

/// The mean depth where half of the light is held back: in spaces that a probe does not know.
fn means(camera: &Camera, model: &Model<'_>, settings: &Settings) -> Result<Vec<f32>, Error> {
    let (quality, depth, antialias) = (1.0, true, Antialias::Off);
    let picture = render(model, camera, &Settings { quality, depth, antialias, ..*settings })?;
    let pixels = picture.depth.iter().zip(picture.rgba.as_chunks::<4>().0);
    Ok(pixels.map(|(t, rgba)| if rgba[3] >= HALF { *t } else { f32::INFINITY }).collect())
}

/// `1 / z = a u + b v + c` by least squares, weighted by how far the taps lie off the plane
/// `before`, as a part of their depth; `None` where they lie on a line.
fn fit(taps: &[Tap], off: f64, before: Option<DVec3>) -> Option<DVec3> {
    let (mut squares, mut sums, mut all) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for Tap { at: [u, v], depth, weight } in taps {
        let at = DVec3::new(*u, *v, 1.0);
        let error = before.map_or(0.0, |plane| plane.dot(at) * depth - 1.0) / off;
        let weight = weight / (1.0 + error * error);
        squares += DMat3::from_cols(at * *u, at * *v, at) * weight;
        sums += at * (weight / depth);
        all += weight;
    }
    let is_plane = squares.determinant() > 1e-4 * all.powi(3);
    is_plane.then(|| squares.inverse() * sums)
}
