//! Light on the surfaces of the built-in scene.
//!
//! Radiance is summed in linear light and encoded by a square root, which is
//! close to sRGB and portable. Albedos are given encoded, so a fully lit
//! surface shows its albedo.

use super::scene::Body;
use super::shapes::Hit;
use super::surface::{GLAZE_HIGHLIGHT, GLAZE_REFLECTION, Surface};
use glam::DVec3;

/// Samples per pixel, and points on the lamp: sample i sees the lamp's point i,
/// so that a pixel's average has soft shadows.
pub(super) const SAMPLES: usize = 16;
/// Half the lamp's width as seen from the scene, radians.
const LAMP_SIZE: f64 = 0.07;
/// Light from everywhere at a surface that faces up, and at one that faces down.
const AMBIENT: [f64; 2] = [0.42, 0.20];
/// Light of the lamp at a surface that faces it.
const LAMP: f64 = 0.72;

/// The scene's light.
#[derive(Debug)]
pub(super) struct Lamp {
    /// The unit vector towards its middle.
    pub(super) direction: DVec3,
    points: [DVec3; SAMPLES],
}

impl Lamp {
    /// The one lamp of the scene: high, and to the side of the pebble.
    pub(super) fn new() -> Self {
        let direction = DVec3::new(3.0, -4.0, 12.0) / 13.0;
        // Two unit vectors across it.
        let (u, v) = (DVec3::new(0.8, 0.6, 0.0), DVec3::new(-7.2, 9.6, 5.0) / 13.0);
        let points = core::array::from_fn(|i| {
            // Another order than the samples' own, so that shadows do not shift with it.
            let k = (i * 7 + 3) % SAMPLES;
            let offset = |j: usize| LAMP_SIZE * (j as f64 - 1.5) / 2.0;
            (direction + u * offset(k % 4) + v * offset(k / 4)).normalize()
        });
        Self { direction, points }
    }
}

/// The encoded colour of `bodies[index]`, hit by a ray along `direction`, from
/// 0 to 1; `sample` chooses the lamp's point.
pub(super) fn shade(
    bodies: &[Body],
    index: usize,
    hit: Hit,
    origin: DVec3,
    direction: DVec3,
    lamp: &Lamp,
    sample: usize,
) -> DVec3 {
    let surface = bodies[index].surface;
    let p = origin + direction * hit.t;
    let towards = lamp.points[sample];
    let facing = hit.normal.dot(towards);
    if surface == Surface::White {
        // Hardly darker on the far side: at most eight of 255 below the background.
        return DVec3::splat(0.985 + 0.015 * facing);
    }
    let lit = facing > 0.0 && !shadowed(bodies, index, p, towards);
    let up = 0.5 + 0.5 * hit.normal.z;
    let ambient = AMBIENT[1] + (AMBIENT[0] - AMBIENT[1]) * up;
    let diffuse = ambient + if lit { LAMP * facing } else { 0.0 };
    let albedo = surface.albedo(p, hit.normal);
    let mut light = albedo * albedo * diffuse;
    if surface == Surface::Glaze {
        let mirrored = direction - hit.normal * (2.0 * direction.dot(hit.normal));
        light += GLAZE_REFLECTION * surroundings(mirrored);
        light += DVec3::splat(GLAZE_HIGHLIGHT * highlight(mirrored, lamp));
    }
    light.to_array().map(|x| x.min(1.0).sqrt()).into()
}

/// The lamp in the glaze: at most 1, where `mirrored` points at the lamp.
pub(super) fn highlight(mirrored: DVec3, lamp: &Lamp) -> f64 {
    lobe(mirrored, lamp.direction, 4)
}

/// What the glaze reflects from the unit direction `d`: a dim floor, a blue
/// sky, and two wide coloured windows. Smooth, so that few harmonics suffice.
fn surroundings(d: DVec3) -> DVec3 {
    let up = 0.5 + 0.5 * d.z;
    let sky = DVec3::new(0.10, 0.22, 0.55) * (up * up);
    let warm = DVec3::new(1.0, 0.42, 0.10) * lobe(d, DVec3::new(-0.8, 0.36, 0.48), 1);
    let cool = DVec3::new(0.10, 0.85, 0.70) * lobe(d, DVec3::new(0.6, 0.64, 0.48), 1);
    sky + warm + cool
}

/// max(0, a · b) to the power 2^`doublings`.
fn lobe(a: DVec3, b: DVec3, doublings: u32) -> f64 {
    (0..doublings).fold(a.dot(b).max(0.0), |x, _| x * x)
}

/// Whether another body stands between `p` on `bodies[index]` and the lamp.
/// Wires are too thin to cast a visible shadow.
fn shadowed(bodies: &[Body], index: usize, p: DVec3, towards: DVec3) -> bool {
    bodies.iter().enumerate().any(|(i, body)| {
        if i == index || body.surface == Surface::Wire {
            return false;
        }
        let (center, radius) = body.shape.bound(0);
        let v = center - p;
        let along = v.dot(towards);
        along > -radius
            && v.dot(v) - along * along < radius * radius
            && body.shape.enter(p, towards).is_some()
    })
}
