//! Lenses that bend: from image points to directions and back.
//!
//! Here camera axes are OpenCV's, x right, y down, looking along +z, and image
//! points are normalised: pixels from the principal point, divided by the focal
//! length. Distortion maps the direction of a point to where the lens shows it;
//! a ray needs the inverse, which is found step by step and checked.

mod ball;
mod radial;
mod render;

use pocketnerf_core::{Camera, Ray};

pub(crate) use ball::Rectangle;
use radial::Radial;
pub(crate) use render::render_through;

/// What lies between a pinhole camera and the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lens {
    /// Nothing.
    #[default]
    Pinhole,
    /// OpenCV's: radial and tangential.
    OpenCv(OpenCv),
    /// OpenCV's fisheye: an image point's radius is a polynomial of the angle.
    Fisheye(Fisheye),
}

/// With r² = x² + y² and d = 1 + k₁ r² + k₂ r⁴ + k₃ r⁶ + k₄ r⁸, the direction
/// (x, y, 1) is seen at (x d + 2 p₁ x y + p₂ (r² + 2 x²), y d + p₁ (r² + 2 y²) + 2 p₂ x y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenCv {
    radial: Radial,
    tangential: [f64; 2],
}

/// A direction at the angle θ from the axis is seen at the radius
/// θ (1 + k₁ θ² + k₂ θ⁴ + k₃ θ⁶ + k₄ θ⁸), on the same side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    radial: Radial,
}

/// The largest angle from the axis that an OpenCV lens shows: a plane has no image
/// of more.
const WIDEST: f64 = 89.0 / 180.0 * std::f64::consts::PI;
/// Newton's steps at most; usual lenses take three.
const STEPS: usize = 20;
/// An image point is found if the lens shows what was found so near to it: far
/// below a pixel.
const CLOSE: f64 = 1e-9;

impl Lens {
    /// OpenCV's lens; [`Lens::Pinhole`] where all coefficients are 0.
    #[must_use]
    pub fn open_cv(k: [f64; 4], p: [f64; 2]) -> Self {
        if k == [0.0; 4] && p == [0.0; 2] {
            return Self::Pinhole;
        }
        Self::OpenCv(OpenCv { radial: Radial::new(k, WIDEST, f64::tan), tangential: p })
    }

    /// OpenCV's fisheye lens; without coefficients the equidistant one.
    #[must_use]
    pub fn fisheye(k: [f64; 4]) -> Self {
        Self::Fisheye(Fisheye { radial: Radial::new(k, std::f64::consts::PI, |angle| angle) })
    }

    /// `pinhole`, `opencv` or `fisheye`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::OpenCv(_) => "opencv",
            Self::Fisheye(_) => "fisheye",
        }
    }

    /// Coefficients: k₁ to k₄, p₁, p₂.
    #[must_use]
    pub const fn coefficients(&self) -> [f64; 6] {
        let ([k1, k2, k3, k4], [p1, p2]) = match self {
            Self::Pinhole => ([0.0; 4], [0.0; 2]),
            Self::OpenCv(lens) => (lens.radial.k, lens.tangential),
            Self::Fisheye(lens) => (lens.radial.k, [0.0; 2]),
        };
        [k1, k2, k3, k4, p1, p2]
    }

    /// Where a direction is shown, normalised; `None` where the lens does not show it:
    /// behind the camera, or so far aside that the polynomial turns back.
    #[must_use]
    pub fn distort(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        match self {
            Self::Pinhole => (z > 0.0).then(|| [x / z, y / z]),
            Self::OpenCv(lens) => {
                let [x, y] = [x / z, y / z];
                (z > 0.0 && x.hypot(y) <= lens.radial.limit).then(|| lens.apply([x, y]))
            }
            Self::Fisheye(lens) => {
                let radius = x.hypot(y);
                let angle = radius.atan2(z);
                let scale = if radius > 0.0 { lens.radial.at(angle) / radius } else { 0.0 };
                (angle <= lens.radial.limit).then_some([x * scale, y * scale])
            }
        }
    }

    /// The direction that is shown at a normalised image point, and whether there is
    /// one. If there is none, the point lies farther out than the lens shows
    /// anything, and the direction is the farthest that it shows on that side.
    #[must_use]
    pub fn undistort(&self, [x, y]: [f64; 2]) -> ([f64; 3], bool) {
        match self {
            Self::Pinhole => ([x, y, 1.0], true),
            Self::OpenCv(lens) => {
                let ([x, y], found) = lens.invert([x, y]);
                ([x, y, 1.0], found)
            }
            Self::Fisheye(lens) => {
                let radius = x.hypot(y);
                let (angle, found) = lens.radial.invert(radius);
                let side = if radius > 0.0 { angle.sin() / radius } else { 0.0 };
                ([x * side, y * side, angle.cos()], found)
            }
        }
    }

    /// The ray through an image point of `camera`, pixels, as [`Camera::ray`], and
    /// bent. Where the lens shows nothing, see [`Lens::undistort`].
    #[must_use]
    pub fn ray(&self, camera: &Camera, x: f32, y: f32) -> Ray {
        if *self == Self::Pinhole {
            return camera.ray(x, y);
        }
        let ([x, y, z], _) = self.undistort(normalised(camera, x, y));
        let m = camera.camera_to_world.map(f64::from);
        let along = |row: usize| m[row] * x - m[row + 1] * y - m[row + 2] * z;
        let direction = glam::DVec3::new(along(0), along(4), along(8));
        let direction = direction.normalize_or(-glam::DVec3::Z).as_vec3().to_array();
        Ray { origin: camera.position(), direction }
    }

    /// Whether anything is shown at an image point of `camera`, pixels.
    #[must_use]
    pub fn shows(&self, camera: &Camera, x: f32, y: f32) -> bool {
        self.undistort(normalised(camera, x, y)).1
    }

    /// The image point at which `camera` sees `p` through the lens, pixels, inside the
    /// picture or not; `None` where the lens does not show it.
    #[must_use]
    pub fn project(&self, camera: &Camera, p: [f32; 3]) -> Option<[f32; 2]> {
        if *self == Self::Pinhole {
            return camera.project(p);
        }
        let [x, y] = self.distort(seen_from(camera, p))?;
        Some(pixels(camera, [x, y]))
    }
}

/// An image point in pixels as a normalised one.
fn normalised(camera: &Camera, x: f32, y: f32) -> [f64; 2] {
    let of = |v: f32, a: usize| {
        (f64::from(v) - f64::from(camera.center[a])) / f64::from(camera.focal[a])
    };
    [of(x, 0), of(y, 1)]
}

/// And back.
fn pixels(camera: &Camera, point: [f64; 2]) -> [f32; 2] {
    [0, 1].map(|a| (f64::from(camera.center[a]) + f64::from(camera.focal[a]) * point[a]) as f32)
}

/// A point of the scene along the axes of a camera: right, down, forward.
fn seen_from(camera: &Camera, p: [f32; 3]) -> [f64; 3] {
    let m = camera.camera_to_world.map(f64::from);
    let d = [0, 1, 2].map(|a| f64::from(p[a]) - m[4 * a + 3]);
    let along = |c: usize| d[0] * m[c] + d[1] * m[4 + c] + d[2] * m[8 + c];
    [along(0), -along(1), -along(2)]
}

impl OpenCv {
    fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [p1, p2] = self.tangential;
        let s = x * x + y * y;
        let d = self.radial.factor(s);
        [
            x * d + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
            y * d + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The point that is shown there: the radial part alone, then Newton's method.
    fn invert(&self, shown: [f64; 2]) -> ([f64; 2], bool) {
        let radius = shown[0].hypot(shown[1]);
        let (r, found) = self.radial.invert(radius);
        let first = shown.map(|v| if radius > 0.0 { v * (r / radius) } else { v });
        if self.tangential == [0.0; 2] {
            return (first, found);
        }
        let [p1, p2] = self.tangential;
        let [mut x, mut y] = first;
        for _ in 0..STEPS {
            let at = self.apply([x, y]);
            let [ex, ey] = [at[0] - shown[0], at[1] - shown[1]];
            if ex.abs().max(ey.abs()) < CLOSE && x.hypot(y) <= self.radial.limit {
                return ([x, y], true);
            }
            let s = x * x + y * y;
            let (d, slope) = (self.radial.factor(s), 2.0 * self.radial.factor_slope(s));
            let xx = d + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
            let yy = d + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
            let xy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
            let determinant = xx * yy - xy * xy;
            x -= (yy * ex - xy * ey) / determinant;
            y -= (xx * ey - xy * ex) / determinant;
        }
        (first, false)
    }
}

#[cfg(test)]
mod tests;
