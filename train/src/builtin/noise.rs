//! Solid noise from an integer hash: the same everywhere, seen from anywhere.

use glam::DVec3;

/// Smooth noise with one random value in [−1, 1] per cubic cell of side `cell`.
/// The lattice is turned against the scene's axes, so that no surface shows it.
pub(super) fn noise(p: DVec3, cell: f64) -> f64 {
    // A rotation with rational entries: rows of (2, −1, 2), (2, 2, −1), (−1, 2, 2) over 3.
    let q = DVec3::new(
        2.0 * p.x - p.y + 2.0 * p.z,
        2.0 * p.x + 2.0 * p.y - p.z,
        -p.x + 2.0 * p.y + 2.0 * p.z,
    ) / (3.0 * cell);
    let corner = q.floor();
    let f = q - corner;
    let w = f * f * (DVec3::splat(3.0) - 2.0 * f);
    let [x, y, z] = corner.to_array().map(|c| c as i64 as u32);
    let along_x = |y: u32, z: u32| mix(random(x, y, z), random(x.wrapping_add(1), y, z), w.x);
    let along_y = |z: u32| mix(along_x(y, z), along_x(y.wrapping_add(1), z), w.y);
    mix(along_y(z), along_y(z.wrapping_add(1)), w.z)
}

/// A random value in [−1, 1] for three integers.
pub(super) fn random(x: u32, y: u32, z: u32) -> f64 {
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ z.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    f64::from(h) * (2.0 / 4_294_967_295.0) - 1.0
}

/// From `a` at `t` = 0 to `b` at `t` = 1.
pub(super) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// A wave of period 1 between 0 and 1 with flat crests: 0 at whole numbers, 1 halfway.
pub(super) fn wave(x: f64) -> f64 {
    let triangle = 1.0 - (2.0 * (x - x.floor()) - 1.0).abs();
    triangle * triangle * (3.0 - 2.0 * triangle)
}
