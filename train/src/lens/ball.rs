//! What a lens shows of a ball: where a part of the scene may be seen.

use pocketnerf_core::Camera;

use super::{Lens, pixels, seen_from, sphere};

/// What a lens shows of a ball.
enum Shown {
    /// All of it, within a disc: centre and radius, normalised.
    Disc([f64; 2], f64),
    /// It is too near, or at the edge of what the lens can show.
    Unknown,
    /// Nothing.
    Nothing,
}

/// A [`Shown`] in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rectangle {
    /// All of it, in here; perhaps outside the picture.
    Within([f32; 4]),
    /// It may be anywhere.
    Unknown,
    /// Nowhere.
    Nothing,
}

impl Lens {
    /// What is shown of the ball around `center` (camera axes, scene units).
    fn ball(&self, center: [f64; 3], radius: f64) -> Shown {
        let [x, y, z] = center;
        let distance = glam::DVec3::from(center).length();
        // What is seen, a radius on its plane or an angle, and how much of that on all sides.
        let (at, spread, bend) = match self {
            Self::Pinhole => return Shown::Unknown,
            Self::Equirectangular => {
                let shown = sphere::ball(center, radius);
                return shown.map_or(Shown::Unknown, |(at, spread)| Shown::Disc(at, spread));
            }
            Self::OpenCv(bend) => {
                if z <= 2.0 * radius {
                    return if z > -radius { Shown::Unknown } else { Shown::Nothing };
                }
                let at = x.hypot(y) / z;
                // A ball off the axis covers more than r / depth: by 1 / cos² at most.
                (at, radius / (z - radius) * (1.0 + at * at), bend)
            }
            Self::Fisheye(bend) => {
                if distance <= 2.0 * radius {
                    return Shown::Unknown;
                }
                (x.hypot(y).atan2(z), (radius / distance).asin(), bend)
            }
        };
        let limit = bend.radial.limit;
        if at - spread > limit {
            return Shown::Nothing;
        }
        let end = at + spread;
        let stretch = match self {
            Self::Pinhole | Self::Equirectangular | Self::OpenCv(_) => bend.steepest(end),
            // Around the axis, a circle's circumference is that of sin θ.
            Self::Fisheye(_) if end < 0.75 * std::f64::consts::PI => {
                bend.steepest(end) * (end / end.sin()).max(1.0)
            }
            Self::Fisheye(_) => f64::INFINITY,
        };
        match self.distort(center) {
            Some(at) if end <= limit && stretch.is_finite() => Shown::Disc(at, stretch * spread),
            _ => Shown::Unknown,
        }
    }

    /// What `camera` sees of a ball (scene units): the rectangle of image points, pixels,
    /// `[x0, y0, x1, y1]`, that holds all of it.
    pub(crate) fn rectangle(&self, camera: &Camera, center: [f32; 3], radius: f32) -> Rectangle {
        match self.ball(seen_from(camera, center), f64::from(radius)) {
            Shown::Unknown => Rectangle::Unknown,
            Shown::Nothing => Rectangle::Nothing,
            Shown::Disc(at, spread) => {
                let [x, y] = pixels(camera, at);
                let [rx, ry] = camera.focal.map(|focal| focal.abs() * spread as f32);
                Rectangle::Within([x - rx, y - ry, x + rx, y + ry])
            }
        }
    }
}
