//! Light on the surfaces of the built-in scenes.
//!
//! Radiance is summed in linear light and encoded by a square root, which is
//! close to sRGB and portable. Albedos are given encoded, so a fully lit
//! surface shows its albedo.

use super::contents::Contents;
use super::shapes::Hit;
use super::surface::{GLAZE_HIGHLIGHT, GLAZE_REFLECTION, Surface};
use glam::DVec3;

/// Samples per pixel, and points on the lamp: sample i sees the lamp's point i,
/// so that a pixel's average has soft shadows.
pub(super) const SAMPLES: usize = 16;
/// Half the lamp's width as seen from the scene, radians.
const LAMP_SIZE: f64 = 0.07;
/// How often a mirror shows another mirror; the last one shows the surroundings alone.
const BOUNCES: u32 = 2;

/// The scene's light.
#[derive(Debug)]
pub(super) struct Light {
    /// The unit vector towards the lamp's middle.
    pub(super) direction: DVec3,
    points: [DVec3; SAMPLES],
    /// Light of the lamp at a surface that faces it.
    lamp: f64,
    /// Light from everywhere at a surface that faces up, and at one that faces down.
    ambient: [f64; 2],
}

impl Light {
    /// One lamp: high, and to the side of the still life's pebble.
    pub(super) fn outdoors() -> Self {
        let direction = DVec3::new(3.0, -4.0, 12.0) / 13.0;
        // Two unit vectors across it.
        let (u, v) = (DVec3::new(0.8, 0.6, 0.0), DVec3::new(-7.2, 9.6, 5.0) / 13.0);
        let points = core::array::from_fn(|i| {
            // Another order than the samples' own, so that shadows do not shift with it.
            let k = (i * 7 + 3) % SAMPLES;
            let offset = |j: usize| LAMP_SIZE * (j as f64 - 1.5) / 2.0;
            (direction + u * offset(k % 4) + v * offset(k / 4)).normalize()
        });
        Self { direction, points, lamp: 0.72, ambient: [0.42, 0.20] }
    }

    /// The same lamp, weaker, where walls give back much of the light.
    pub(super) fn indoors() -> Self {
        Self { lamp: 0.36, ambient: [0.60, 0.46], ..Self::outdoors() }
    }
}

/// The encoded colour of `bodies[index]`, hit by a ray along `direction`, from
/// 0 to 1; `sample` chooses the lamp's point.
pub(super) fn shade(
    contents: &Contents,
    index: usize,
    hit: Hit,
    origin: DVec3,
    direction: DVec3,
    sample: usize,
) -> DVec3 {
    if contents.bodies[index].surface == Surface::White {
        // Hardly darker on the far side: at most eight of 255 below the background.
        let facing = hit.normal.dot(contents.light.points[sample]);
        return DVec3::splat(0.985 + 0.015 * facing);
    }
    let light = radiance(contents, (index, hit), origin, direction, sample, BOUNCES);
    light.to_array().map(|x| x.min(1.0).sqrt()).into()
}

/// Linear light from a point of a body towards `origin`.
fn radiance(
    contents: &Contents,
    (index, hit): (usize, Hit),
    origin: DVec3,
    direction: DVec3,
    sample: usize,
    bounces: u32,
) -> DVec3 {
    let light = &contents.light;
    let surface = contents.bodies[index].surface;
    let p = origin + direction * hit.t;
    let towards = light.points[sample];
    let facing = hit.normal.dot(towards);
    let lit = facing > 0.0 && !contents.shadowed(index, p, towards);
    let up = 0.5 + 0.5 * hit.normal.z;
    let ambient = light.ambient[1] + (light.ambient[0] - light.ambient[1]) * up;
    let lamp = if lit { light.lamp * facing * contents.lamplight(p, towards) } else { 0.0 };
    let albedo = surface.albedo(p, hit.normal);
    let matt = albedo * albedo * (ambient + lamp);
    let mirrored = direction - hit.normal * (2.0 * direction.dot(hit.normal));
    match surface {
        Surface::Glaze => {
            let shine = DVec3::splat(GLAZE_HIGHLIGHT * highlight(mirrored, light));
            matt + GLAZE_REFLECTION * surroundings(mirrored) + shine
        }
        Surface::Mirror { reflectance, .. } => {
            let seen = match contents.first_from(index, p, mirrored) {
                Some(other) if bounces > 0 => {
                    radiance(contents, other, p, mirrored, sample, bounces - 1)
                }
                _ => studio(mirrored, light),
            };
            // Schlick's approximation: at a grazing angle everything is a mirror.
            let graze = 1.0 - mirrored.dot(hit.normal).clamp(0.0, 1.0);
            let share = reflectance + (1.0 - reflectance) * graze * square(graze * graze);
            matt * (1.0 - share) + seen * share
        }
        _ => matt,
    }
}

/// The lamp in the glaze: at most 1, where `mirrored` points at the lamp.
pub(super) fn highlight(mirrored: DVec3, light: &Light) -> f64 {
    lobe(mirrored, light.direction, 4)
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

/// What a mirror reflects where it sees no body: a dark floor, a sky, three windows with
/// soft edges, and the lamp as a sharp spot.
fn studio(d: DVec3, light: &Light) -> DVec3 {
    let up = 0.5 + 0.5 * d.z;
    let sky = DVec3::new(0.10, 0.16, 0.30) * square(up);
    let warm = DVec3::new(1.0, 0.58, 0.20) * lobe(d, DVec3::new(-0.8, 0.36, 0.48), 2);
    let cool = DVec3::new(0.20, 0.85, 0.80) * lobe(d, DVec3::new(0.6, 0.64, 0.48), 2);
    let pink = DVec3::new(0.95, 0.35, 0.60) * lobe(d, DVec3::new(0.28, -0.96, 0.0), 2);
    sky + warm + cool + pink + DVec3::splat(1.5 * lobe(d, light.direction, 8))
}

fn square(x: f64) -> f64 {
    x * x
}

/// max(0, a · b) to the power 2^`doublings`.
fn lobe(a: DVec3, b: DVec3, doublings: u32) -> f64 {
    (0..doublings).fold(a.dot(b).max(0.0), |x, _| x * x)
}
