//! The sky: infinitely far, a function of direction alone.

use super::noise::noise;
use super::surface::mix3;
use glam::DVec3;

/// Encoded colours at the horizon, overhead and of the clouds.
pub(super) const HORIZON: DVec3 = DVec3::new(0.86, 0.90, 0.94);
pub(super) const ZENITH: DVec3 = DVec3::new(0.30, 0.52, 0.84);
pub(super) const CLOUD: DVec3 = DVec3::new(0.97, 0.97, 0.98);

/// The encoded colour in the unit direction `d`.
pub(super) fn sky(d: DVec3) -> DVec3 {
    let up = d.z.clamp(0.0, 1.0);
    let clear = mix3(HORIZON, ZENITH, up * (2.0 - up));
    // Flat clouds, and none at the horizon.
    let q = DVec3::new(d.x, d.y, 2.0 * d.z);
    let puffs = noise(q, 0.5) + 0.5 * noise(q, 0.25) + 0.25 * noise(q, 0.125);
    let cover = (0.6 * puffs + 0.4).clamp(0.0, 1.0);
    let cover = cover * cover * (3.0 - 2.0 * cover) * (4.0 * up).min(1.0);
    mix3(clear, CLOUD, 0.9 * cover)
}
