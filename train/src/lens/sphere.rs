//! Panoramas: longitude along x, latitude along y.
//!
//! The middle of the picture is forward (camera axes as in the module above), longitude grows to
//! the right and latitude down; a whole turn is as wide as the picture, from straight up to
//! straight down as high. So for nerfstudio's and Metashape's equirectangular cameras.

use std::f64::consts::{FRAC_PI_2, PI};

/// A picture of a whole turn ends where it begins: rounding must not take its edge away.
const SLACK: f64 = 1e-6;

/// Longitude and latitude of a direction, radians.
pub(super) fn distort([x, y, z]: [f64; 3]) -> [f64; 2] {
    [x.atan2(z), y.atan2(x.hypot(z))]
}

/// The direction at a longitude and latitude, and whether there is one: else the nearest.
pub(super) fn undistort([longitude, latitude]: [f64; 2]) -> ([f64; 3], bool) {
    let is_shown = longitude.abs() <= PI + SLACK && latitude.abs() <= FRAC_PI_2 + SLACK;
    let (longitude, latitude) = (longitude.clamp(-PI, PI), latitude.clamp(-FRAC_PI_2, FRAC_PI_2));
    let ([s, c], [up, along]) =
        ([longitude.sin(), longitude.cos()], [latitude.sin(), latitude.cos()]);
    ([s * along, up, c * along], is_shown)
}

/// Longitude and latitude of a ball's middle, and how far it reaches from there in either;
/// `None` where it meets the seam behind the camera or comes near a pole.
pub(super) fn ball(center: [f64; 3], radius: f64) -> Option<([f64; 2], f64)> {
    let distance = glam::DVec3::from(center).length();
    if distance <= 2.0 * radius {
        return None;
    }
    let at = distort(center);
    let angle = (radius / distance).asin();
    let across = angle.sin() / at[1].cos();
    if at[1].abs() + angle >= 0.95 * FRAC_PI_2 || across >= 1.0 {
        return None;
    }
    let spread = across.asin().max(angle);
    (at[0].abs() + spread < PI).then_some((at, spread))
}
