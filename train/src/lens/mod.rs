//! Lenses that bend: from image points to directions and back.
//!
//! Here camera axes are OpenCV's, x right, y down, looking along +z, and image
//! points are normalised: pixels from the principal point, divided by the focal
//! length. Distortion maps the direction of a point to where the lens shows it;
//! a ray needs the inverse, which is found step by step and checked.

mod ball;
mod bend;
mod radial;
mod render;
mod sphere;

use std::f64::consts::PI;

use pocketnerf_core::{Camera, Ray};

pub(crate) use ball::Rectangle;
pub use bend::Bend;
use radial::{Curve, Radial};
pub(crate) use render::render_through;

/// What lies between a pinhole camera and the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lens {
    /// Nothing.
    #[default]
    Pinhole,
    /// As OpenCV's: the point (x, y) at which a pinhole camera shows the direction
    /// (x, y, 1) moves.
    OpenCv(Bend),
    /// As OpenCV's fisheye: a direction at the angle θ from the axis is shown at the
    /// radius θ on its side, and that point moves.
    Fisheye(Bend),
    /// A panorama: normalised image points are longitude and latitude, radians. What asks
    /// [`Camera`] itself for a ray gets that of a pinhole camera.
    Equirectangular,
}

/// The largest angle from the axis that an OpenCV lens shows: a plane has no image
/// of more.
const WIDEST: f64 = 89.0 / 180.0 * PI;
/// Below this |ω|, radians, the field-of-view lens moves no point that can be told.
const NO_FOV: f64 = 1e-6;
/// Newton's steps at most; usual lenses take three.
const STEPS: usize = 20;
/// An image point is found if the lens shows what was found so near to it: far
/// below a pixel.
const CLOSE: f64 = 1e-9;

impl Lens {
    /// OpenCV's lens: radial d = 1 + k₁ r² + k₂ r⁴ + k₃ r⁶ + k₄ r⁸, and tangential.
    /// [`Lens::Pinhole`] where all coefficients are 0.
    #[must_use]
    pub fn open_cv(k: [f64; 4], p: [f64; 2]) -> Self {
        if k == [0.0; 4] && p == [0.0; 2] {
            return Self::Pinhole;
        }
        Self::on_a_plane(Curve::Polynomial(k), p)
    }

    /// OpenCV's rational lens: d = (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) / (1 + k₄ r² + k₅ r⁴ + k₆ r⁶),
    /// and tangential.
    #[must_use]
    pub fn full_open_cv([k1, k2, k3, below @ ..]: [f64; 6], p: [f64; 2]) -> Self {
        if below == [0.0; 3] {
            return Self::open_cv([k1, k2, k3, 0.0], p);
        }
        Self::on_a_plane(Curve::Rational([k1, k2, k3], below), p)
    }

    /// The field-of-view lens of Devernay and Faugeras: r moves to atan(2 r tan(ω / 2)) / ω,
    /// with ω in radians, below π on both sides of 0.
    #[must_use]
    pub fn fov(omega: f64) -> Self {
        if omega.abs() < NO_FOV {
            return Self::Pinhole;
        }
        Self::on_a_plane(Curve::Fov(omega), [0.0; 2])
    }

    fn on_a_plane(curve: Curve, tangential: [f64; 2]) -> Self {
        let bend = Bend::radial(Radial::new(curve, WIDEST, f64::tan));
        Self::OpenCv(Bend { tangential, ..bend })
    }

    /// OpenCV's fisheye lens: the radius is θ (1 + k₁ θ² + k₂ θ⁴ + k₃ θ⁶ + k₄ θ⁸); without
    /// coefficients the equidistant one.
    #[must_use]
    pub fn fisheye(k: [f64; 4]) -> Self {
        Self::thin_prism_fisheye(k, [0.0; 2], [0.0; 2])
    }

    /// The same with tangential coefficients p and those of a thin prism, s.
    #[must_use]
    pub fn thin_prism_fisheye(k: [f64; 4], p: [f64; 2], s: [f64; 2]) -> Self {
        let radial = Radial::new(Curve::Polynomial(k), PI, |angle| angle);
        Self::Fisheye(Bend { tangential: p, prism: s, ..Bend::radial(radial) })
    }

    /// The same lens before a sensor on which x also grows with y, by this much. A panorama has
    /// none.
    #[must_use]
    pub fn skewed(self, skew: f64) -> Self {
        if skew == 0.0 {
            return self;
        }
        match self {
            Self::Pinhole => Self::on_a_plane(Curve::Polynomial([0.0; 4]), [0.0; 2]).skewed(skew),
            Self::OpenCv(bend) => Self::OpenCv(Bend { skew, ..bend }),
            Self::Fisheye(bend) => Self::Fisheye(Bend { skew, ..bend }),
            Self::Equirectangular => self,
        }
    }

    /// `pinhole`, `opencv`, `full-opencv`, `fov`, `fisheye`, `thin-prism-fisheye`,
    /// `skewed-opencv`, `skewed-fisheye` or `equirectangular`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::Equirectangular => "equirectangular",
            Self::OpenCv(bend) if bend.skew != 0.0 => "skewed-opencv",
            Self::Fisheye(bend) if bend.skew != 0.0 => "skewed-fisheye",
            Self::OpenCv(bend) => match bend.radial.curve {
                Curve::Polynomial(_) => "opencv",
                Curve::Rational(..) => "full-opencv",
                Curve::Fov(_) => "fov",
            },
            Self::Fisheye(bend) if bend.is_radial() => "fisheye",
            Self::Fisheye(_) => "thin-prism-fisheye",
        }
    }

    /// Coefficients: k₁ to k₄ (k₆ of a rational lens) or ω, p₁, p₂, s₁ and s₂ of a thin prism,
    /// and the skew of a skewed sensor.
    #[must_use]
    pub fn coefficients(&self) -> Vec<f64> {
        let (Self::OpenCv(bend) | Self::Fisheye(bend)) = self else { return Vec::new() };
        let mut all = match bend.radial.curve {
            Curve::Polynomial(k) => k.to_vec(),
            Curve::Rational(k, below) => [k, below].concat(),
            Curve::Fov(omega) => vec![omega],
        };
        all.extend(bend.tangential);
        if bend.prism != [0.0; 2] {
            all.extend(bend.prism);
        }
        if bend.skew != 0.0 {
            all.push(bend.skew);
        }
        all
    }

    /// Where a direction is shown, normalised; `None` where the lens does not show it:
    /// behind the camera, or so far aside that the polynomial turns back.
    #[must_use]
    pub fn distort(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        match self {
            Self::Pinhole => (z > 0.0).then(|| [x / z, y / z]),
            Self::OpenCv(bend) if z > 0.0 => bend.distort([x / z, y / z]),
            Self::OpenCv(_) => None,
            Self::Equirectangular => Some(sphere::distort([x, y, z])),
            Self::Fisheye(bend) => {
                let radius = x.hypot(y);
                let angle = radius.atan2(z);
                let scale = if radius > 0.0 { angle / radius } else { 0.0 };
                // Straight behind there is no side.
                if angle < PI { bend.distort([x * scale, y * scale]) } else { None }
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
            Self::Equirectangular => sphere::undistort([x, y]),
            Self::OpenCv(bend) => {
                let ([x, y], found) = bend.invert([x, y]);
                ([x, y, 1.0], found)
            }
            Self::Fisheye(bend) => {
                let ([x, y], found) = bend.invert([x, y]);
                let angle = x.hypot(y);
                let side = if angle > 0.0 { angle.sin() / angle } else { 0.0 };
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

#[cfg(test)]
mod tests;
